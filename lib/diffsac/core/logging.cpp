#include "diffsac/core/logging.h"

#include <cstdio>
#include <utility>

namespace diffsac {
namespace {

void WarnOnStderr(LogLevel level, const std::string& line) {
  if (level == LogLevel::kWarning) std::fprintf(stderr, "diffsac: %s\n", line.c_str());
}

LogFunction& Log() {
  static LogFunction log = WarnOnStderr;
  return log;
}

void Write(LogLevel level, const std::string& line) {
  if (const LogFunction& log = Log()) log(level, line);
}

}  // namespace

LogFunction SetLog(LogFunction log) { return std::exchange(Log(), std::move(log)); }
void LogInfo(const std::string& line) { Write(LogLevel::kInfo, line); }
void LogWarning(const std::string& line) { Write(LogLevel::kWarning, line); }

}  // namespace diffsac
