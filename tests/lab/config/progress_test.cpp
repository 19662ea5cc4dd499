#include "lab/config/progress.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/temporary_folder.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

/// Puts the log back at the end of a test.
struct LogGuard {
  LogFunction old = SetLog(nullptr);
  ~LogGuard() { SetLog(old); }
};

}  // namespace

TEST_CASE("ProgressText shows share, rate and time left") {
  CHECK(ProgressText(50, 200, 10.0, "loss 0.12") == "25% 50/200 5.00/s, 0:30 left, loss 0.12");
  CHECK(ProgressText(200, 200, 3700.0) == "100% 200/200 0.05/s, took 1:01:40");
  CHECK(ProgressText(199, 200, 1.0).substr(0, 4) == "99% ");
  CHECK(ProgressText(0, 200, 5.0) == "0% 0/200");
  CHECK(ProgressText(50, 200, 10.0, "", 90.0) == "25% 50/200 5.00/s, 1:30 left");
  CHECK(ProgressText(30, 0, 2.0) == "30 15.0/s, took 0:02");
}

TEST_CASE("Progress off a terminal ends with one plain line") {
  const LogGuard guard;
  std::string text;
  SetLog([&](LogLevel, const std::string& line) { text += line + "\n"; });
  Progress progress("training", 1000);
  ParallelFor(1000, 4, [&](std::int64_t) { progress.Advance(1, "loss 1"); });
  progress.Finish();
  progress.Finish();
  // On a terminal a bar goes to stderr instead.
  if (!text.empty()) {
    CHECK(text.find("training: 100% 1000/1000 ") == 0);
    CHECK(text.find("loss 1\n") == text.size() - 7);
  }
}

TEST_CASE("InitLogging appends to its file and refuses one it cannot write") {
  const LogGuard guard;
  const TemporaryFolder folder;
  for (const char* line : {"first", "second"}) {
    InitLogging(folder.File("log.txt"), true);
    LogInfo(line);
  }
  const std::string text = ReadFile(folder.File("log.txt"));
  CHECK_THAT(text, Catch::Contains("[info] first\n") && Catch::Contains("[info] second\n"));
  CHECK_THROWS_AS(InitLogging(folder.File("log.txt/below")), Error);
}

}  // namespace diffsac
