#pragma once

#include <spdlog/spdlog.h>

#include <string>

namespace diffsac {

/// Terminal (coloured, stderr) and, when `file` is not empty, a log file as well. Call once in a program.
void InitLogging(const std::string& file = "", bool quiet = false);

}  // namespace diffsac
