#include "diffsac/guidance/diffusion/noise_schedule.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

constexpr double kCosineOffset = 0.008;
constexpr double kMaxBeta = 0.999;
// The number of steps for which the linear schedule's ends were chosen.
constexpr double kLinearReferenceSteps = 1000.0;
// Above this signal-to-noise ratio the last step shows the labels, and sampling from pure noise starts elsewhere.
constexpr double kMaxTerminalSnr = 0.01;

double CosineAlphaBar(double fraction) {
  const double c = std::cos((fraction + kCosineOffset) / (1.0 + kCosineOffset) * std::numbers::pi / 2.0);
  return c * c;
}

std::vector<double> CosineBetas(int steps) {
  std::vector<double> betas(steps);
  for (int t = 0; t < steps; ++t) {
    const double ratio = CosineAlphaBar((t + 1.0) / steps) / CosineAlphaBar(static_cast<double>(t) / steps);
    betas[t] = std::min(1.0 - ratio, kMaxBeta);
  }
  return betas;
}

std::vector<double> LinearBetas(int steps, double start, double end) {
  std::vector<double> betas(steps, start);
  for (int t = 1; t < steps; ++t) betas[t] = start + (end - start) * t / (steps - 1);
  return betas;
}

std::vector<double> Betas(const NoiseScheduleOptions& options) {
  if (options.kind == NoiseScheduleKind::kCosine) return CosineBetas(options.steps);
  const double scale = options.kind == NoiseScheduleKind::kLinearScaled ? kLinearReferenceSteps / options.steps : 1.0;
  return LinearBetas(options.steps, scale * options.beta_start, scale * options.beta_end);
}

void RescaleToZeroTerminalSnr(std::vector<double>& alphas_bar) {
  const double first = std::sqrt(alphas_bar.front());
  const double last = std::sqrt(alphas_bar.back());
  for (double& alpha_bar : alphas_bar) {
    const double root = (std::sqrt(alpha_bar) - last) * first / (first - last);
    alpha_bar = root * root;
  }
  alphas_bar.back() = 0.0;
}

std::string TerminalSnrText(const std::string& kind, int steps, double snr) {
  char ratio[32];
  std::snprintf(ratio, sizeof ratio, "%.3f", snr);
  return "noise schedule " + kind + " with " + std::to_string(steps) +
         " steps: the last step's signal-to-noise ratio is " + ratio +
         ", so training sees the labels in what should be pure noise; consider cosine, linear_scaled or "
         "zero_terminal_snr";
}

void Check(const NoiseScheduleOptions& o) {
  const auto require = [](bool ok, const char* expected) {
    if (!ok) throw Error(std::string("noise schedule: ") + expected);
  };
  require(o.steps >= 1 && o.steps <= 100000, "steps: expected from 1 to 100000");
  require(o.beta_start > 0.0 && o.beta_end >= o.beta_start && o.beta_end <= 0.999,
          "beta_end: expected at least beta_start, both above 0 and at most 0.999");
  require(o.kind != NoiseScheduleKind::kLinearScaled || kLinearReferenceSteps / o.steps * o.beta_end < 1.0,
          "steps: expected more for linear_scaled, so that beta_end * 1000 / steps is below 1");
  require(!o.zero_terminal_snr || o.steps >= 2, "steps: expected at least 2 with zero_terminal_snr");
}

}  // namespace

NoiseSchedule::NoiseSchedule(const NoiseScheduleOptions& options) : options_(options) {
  Check(options);
  betas_ = Betas(options_);
  double product = 1.0;
  for (const double beta : betas_) alphas_bar_.push_back(product *= 1.0 - beta);
  if (options_.zero_terminal_snr) {
    RescaleToZeroTerminalSnr(alphas_bar_);
    for (std::size_t t = 1; t < betas_.size(); ++t) betas_[t] = 1.0 - alphas_bar_[t] / alphas_bar_[t - 1];
  }
  for (const double beta : betas_) alphas_.push_back(1.0 - beta);

  if (TerminalSnr() > kMaxTerminalSnr) {
    LogWarning(TerminalSnrText(ToString(options_.kind), steps(), TerminalSnr()));
  }
}

std::size_t NoiseSchedule::Index(int t) const {
  if (t < 0 || t >= steps()) {
    throw Error("noise schedule: timestep " + std::to_string(t) + " is outside [0, " + std::to_string(steps()) + ")");
  }
  return static_cast<std::size_t>(t);
}

double NoiseSchedule::alpha(int t) const { return std::sqrt(alphas_bar_[Index(t)]); }
double NoiseSchedule::sigma(int t) const { return std::sqrt(1.0 - alphas_bar_[Index(t)]); }

double NoiseSchedule::lambda(int t) const {
  const double alpha_bar = alphas_bar_[Index(t)];
  return 0.5 * std::log(alpha_bar / (1.0 - alpha_bar));
}

double NoiseSchedule::TerminalSnr() const { return alphas_bar_.back() / (1.0 - alphas_bar_.back()); }

}  // namespace diffsac
