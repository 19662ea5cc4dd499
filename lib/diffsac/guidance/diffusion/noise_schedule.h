#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "diffsac/core/enum_names.h"

namespace diffsac {

/// How the variances run.
///   kCosine        "cosine": Nichol and Dhariwal, "Improved denoising diffusion probabilistic models", ICML 2021, s =
///                  0.008, β ≤ 0.999
///   kLinear        "linear": Ho et al., "Denoising diffusion probabilistic models", NeurIPS 2020; made for T = 1000:
///                  with T = 100 the last step still shows the labels, so it warns
///   kLinearScaled  "linear_scaled": linear with both ends times 1000/T
enum class NoiseScheduleKind { kCosine, kLinear, kLinearScaled };
template <>
inline constexpr auto kEnumNames<NoiseScheduleKind> =
    NamesOf<NoiseScheduleKind>({{NoiseScheduleKind::kCosine, "cosine"},
                                {NoiseScheduleKind::kLinear, "linear"},
                                {NoiseScheduleKind::kLinearScaled, "linear_scaled"}});

/// Which variances β_1…β_T the forward process adds.
struct NoiseScheduleOptions {
  NoiseScheduleKind kind = NoiseScheduleKind::kCosine;
  /// T.
  int steps = 100;
  /// First and last β of the linear kinds, before scaling.
  double beta_start = 1e-4;
  double beta_end = 0.02;
  /// Shifts and scales √ᾱ so that ᾱ_T = 0 and ᾱ_1 stays (Lin et al., "Common diffusion noise schedules and sample
  /// steps are flawed", WACV 2024).
  bool zero_terminal_snr = false;
};

/// The variance-preserving forward process q(c_t | c_0) = N(α_t c_0, σ_t² I) with α_t = √ᾱ_t and σ_t = √(1 − ᾱ_t),
/// the paper's Eq. (2), in float64.
///
/// Every timestep here is an index t in 0…T−1 and stands for the paper's t + 1: index 0 is the least noisy step,
/// index T−1 pure noise (nearly). Clean data has no index.
class NoiseSchedule {
 public:
  /// Throws Error on bad options, naming the key. Warns in the log, once a construction, when the last step still
  /// carries signal.
  explicit NoiseSchedule(const NoiseScheduleOptions& options = {});

  /// T.
  int steps() const { return static_cast<int>(betas_.size()); }
  const NoiseScheduleOptions& options() const { return options_; }

  /// Element t is β, α = 1 − β (the paper's α_t, not the signal's scale) or ᾱ of index t.
  const std::vector<double>& betas() const { return betas_; }
  const std::vector<double>& alphas() const { return alphas_; }
  const std::vector<double>& alphas_bar() const { return alphas_bar_; }

  /// Scale of the signal, √ᾱ. t in [0, T), else Error; so for the next three.
  double alpha(int t) const;
  /// Scale of the noise, √(1 − ᾱ).
  double sigma(int t) const;
  /// log(α/σ), falling in t; −∞ at T−1 with zero terminal SNR.
  double lambda(int t) const;
  /// Signal-to-noise ratio ᾱ/(1 − ᾱ) of the last step.
  double TerminalSnr() const;

 private:
  std::size_t Index(int t) const;

  NoiseScheduleOptions options_;
  std::vector<double> betas_, alphas_, alphas_bar_;
};

}  // namespace diffsac
