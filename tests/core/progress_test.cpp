#include "diffsac/core/progress.h"

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <sstream>

#include "core/temporary_folder.h"
#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

/// Puts the default logger back at the end of a test.
struct LoggerGuard {
  std::shared_ptr<spdlog::logger> old = spdlog::default_logger();
  ~LoggerGuard() { spdlog::set_default_logger(old); }
};

}  // namespace

TEST_CASE("ProgressText shows share, rate and time left") {
  CHECK(ProgressText(50, 200, 10.0, "loss 0.12") == "25% 50/200 5.00/s, 0:30 left, loss 0.12");
  CHECK(ProgressText(200, 200, 3700.0) == "100% 200/200 0.05/s, took 1:01:40");
  CHECK(ProgressText(199, 200, 1.0).substr(0, 4) == "99% ");
  CHECK(ProgressText(0, 200, 5.0) == "0% 0/200");
  CHECK(ProgressText(30, 0, 2.0) == "30 15.0/s, took 0:02");
}

TEST_CASE("Progress off a terminal ends with one plain line") {
  const LoggerGuard guard;
  std::ostringstream text;
  auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(text);
  sink->set_pattern("%v");
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", sink));
  Progress progress("training", 1000);
  ParallelFor(1000, 4, [&](std::int64_t) { progress.Advance(1, "loss 1"); });
  progress.Finish();
  progress.Finish();
  // On a terminal a bar goes to stderr instead.
  if (!text.str().empty()) {
    CHECK(text.str().find("training: 100% 1000/1000 ") == 0);
    CHECK(text.str().find("loss 1\n") == text.str().size() - 7);
  }
}

TEST_CASE("InitLogging appends to its file and refuses one it cannot write") {
  const LoggerGuard guard;
  const TemporaryFolder folder;
  for (const char* line : {"first", "second"}) {
    InitLogging(folder.File("log.txt"), true);
    spdlog::info(line);
  }
  const std::string text = ReadFile(folder.File("log.txt"));
  CHECK_THAT(text, Catch::Contains("[info] first\n") && Catch::Contains("[info] second\n"));
  CHECK_THROWS_AS(InitLogging(folder.File("log.txt/below")), Error);
}

}  // namespace diffsac
