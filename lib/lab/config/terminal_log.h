#pragma once

#include <string>

namespace diffsac {

/// Sends the log to the terminal (coloured, stderr) and, when `file` is not empty, to a log file as well, by spdlog.
/// Call once in a program. Files that see LibTorch must not see spdlog (both bring a version of fmt): they call
/// core/logging.h.
void InitLogging(const std::string& file = "", bool quiet = false);

}  // namespace diffsac
