#pragma once

#include <functional>
#include <string>

namespace diffsac {

enum class LogLevel { kInfo, kWarning };

/// Where the library's messages go, from any thread. Before the first call warnings go to stderr and the rest nowhere;
/// `nullptr` silences all. Returns what was set before. Not while other threads log.
using LogFunction = std::function<void(LogLevel, const std::string& line)>;
LogFunction SetLog(LogFunction log);

/// One line of the log.
void LogInfo(const std::string& line);
void LogWarning(const std::string& line);

}  // namespace diffsac
