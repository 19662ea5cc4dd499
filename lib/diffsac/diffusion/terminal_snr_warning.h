#pragma once

#include <string>

namespace diffsac {

/// Logs that a schedule's last step still carries signal.
void WarnOfTerminalSnr(const std::string& kind, int steps, double snr);

}  // namespace diffsac
