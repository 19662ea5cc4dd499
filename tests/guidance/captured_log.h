#pragma once

#include <functional>
#include <string>

#include "diffsac/core/logging.h"

namespace diffsac {

/// What is logged while `run` runs, a line each.
inline std::string CapturedLog(const std::function<void()>& run) {
  std::string text;
  const LogFunction before = SetLog([&](LogLevel, const std::string& line) { text += line + "\n"; });
  run();
  SetLog(before);
  return text;
}

}  // namespace diffsac
