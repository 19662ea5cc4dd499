#pragma once

#include <array>

namespace diffsac {

/// How many similarities there are of about each scale and turn: counts in cells of 0.1 (log scale, up to ±3) and
/// 2π / 64 (turn), smoothed with a Gaussian of 0.3 in both.
class TurnScaleHistogram {
 public:
  void Add(float log_scale, float turn);
  /// After the last Add.
  void Smooth();
  /// exp(−(Δ log s)² / 2σ² − Δθ² / 2σ²) from the cell of a similarity to those that were added, their mean. `included`:
  /// whether it was added itself: it does not count then. 0 where there are no others.
  float MeanOfOthers(float log_scale, float turn, bool included) const;

 private:
  static constexpr int kTurns = 64, kMostScale = 30, kScales = 2 * kMostScale + 1;

  static int CellOf(float log_scale, float turn);

  int added_ = 0;
  std::array<int, kScales* kTurns> counts_ = {};
  std::array<float, kScales* kTurns> smoothed_ = {};
};

}  // namespace diffsac
