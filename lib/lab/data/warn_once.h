#pragma once

#include <string>

namespace diffsac {

/// LogWarning, once in a process for the same line: data sets are read again for pictures and labels. Thread-safe.
void WarnOnce(const std::string& line);

}  // namespace diffsac
