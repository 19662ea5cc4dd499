#pragma once

#include <string>

namespace diffsac {

/// Terminal (coloured, stderr) and, when `file` is not empty, a log file as well. Call once in a program.
void InitLogging(const std::string& file = "", bool quiet = false);

/// One line of the log. Files that see LibTorch must not see spdlog (both bring a version of fmt), so these are plain calls.
void LogInfo(const std::string& line);
void LogWarning(const std::string& line);

}  // namespace diffsac
