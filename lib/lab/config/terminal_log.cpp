#include "lab/config/terminal_log.h"

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <memory>
#include <vector>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

spdlog::sink_ptr TerminalSink(bool quiet) {
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  // On a terminal a line first wipes the progress bar that may stand there; the bar redraws itself.
  const std::string wipe = ::isatty(STDERR_FILENO) ? "\r\033[K" : "";
  sink->set_pattern(wipe + "[%H:%M:%S] [%^%l%$] %v");
  sink->set_level(quiet ? spdlog::level::warn : spdlog::level::info);
  return sink;
}

spdlog::sink_ptr FileSink(const std::string& file) {
  try {
    // Appends, so that a resumed run keeps what it logged before.
    auto sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(file, false);
    sink->set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%l] %v");
    return sink;
  } catch (const spdlog::spdlog_ex& exception) {
    throw Error("cannot write the log file '" + file + "': " + exception.what());
  }
}

}  // namespace

void InitLogging(const std::string& file, bool quiet) {
  std::vector<spdlog::sink_ptr> sinks = {TerminalSink(quiet)};
  if (!file.empty()) sinks.push_back(FileSink(file));
  auto logger = std::make_shared<spdlog::logger>("diffsac", sinks.begin(), sinks.end());
  logger->set_level(spdlog::level::info);
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
  SetLog([](LogLevel level, const std::string& line) {
    spdlog::log(level == LogLevel::kWarning ? spdlog::level::warn : spdlog::level::info, "{}", line);
  });
}

}  // namespace diffsac
