#pragma once

#include <functional>
#include <string>

namespace diffsac {

/// What `body` writes to the log; the default logger is put back afterwards.
std::string CapturedLog(const std::function<void()>& body);

}  // namespace diffsac
