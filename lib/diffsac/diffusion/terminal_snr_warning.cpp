#include "diffsac/diffusion/terminal_snr_warning.h"

#include <spdlog/spdlog.h>

namespace diffsac {

void WarnOfTerminalSnr(const std::string& kind, int steps, double snr) {
  spdlog::warn(
      "noise schedule {} with {} steps: the last step's signal-to-noise ratio is {:.3f}, so training sees the labels "
      "in what should be pure noise; consider cosine, linear_scaled or zero_terminal_snr",
      kind, steps, snr);
}

}  // namespace diffsac
