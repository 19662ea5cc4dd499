#include "diffsac/problem/turn_scale_histogram.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace diffsac {
namespace {

constexpr double kScaleCell = 0.1, kSigma = 0.3;
// Farther cells weigh less than .02.
constexpr int kReach = 9;

// Of a cell and those on both sides of it.
std::array<float, 2 * kReach + 1> Weights(double cell) {
  std::array<float, 2 * kReach + 1> weights;
  for (int k = -kReach; k <= kReach; ++k)
    weights[k + kReach] = static_cast<float>(std::exp(-0.5 * (k * cell / kSigma) * (k * cell / kSigma)));
  return weights;
}

}  // namespace

// Rounded so that a similarity and its inverse lie in opposite cells.
int TurnScaleHistogram::CellOf(float log_scale, float turn) {
  const double cell = 2.0 * std::numbers::pi / kTurns;
  const auto scale = std::clamp<long>(std::lround(log_scale / kScaleCell), -kMostScale, kMostScale);
  const auto place = static_cast<int>(std::lround(turn / cell) % kTurns);
  return static_cast<int>(scale + kMostScale) * kTurns + (place + kTurns) % kTurns;
}

void TurnScaleHistogram::Add(float log_scale, float turn) {
  counts_[CellOf(log_scale, turn)] += 1;
  added_ += 1;
}

void TurnScaleHistogram::Smooth() {
  const auto over_scales = Weights(kScaleCell), over_turns = Weights(2.0 * std::numbers::pi / kTurns);
  std::array<float, kScales* kTurns> along_turns = {};
  for (int cell = 0; cell < kScales * kTurns; ++cell) {
    if (counts_[cell] == 0) continue;
    const int scale = cell / kTurns, turn = cell % kTurns;
    for (int k = -kReach; k <= kReach; ++k)
      along_turns[scale * kTurns + (turn + k + kTurns) % kTurns] +=
          over_turns[k + kReach] * static_cast<float>(counts_[cell]);
  }
  smoothed_ = {};
  for (int scale = 0; scale < kScales; ++scale) {
    const int first = std::max(scale - kReach, 0), last = std::min(scale + kReach, kScales - 1);
    for (int other = first; other <= last; ++other)
      for (int turn = 0; turn < kTurns; ++turn)
        smoothed_[scale * kTurns + turn] += over_scales[other - scale + kReach] * along_turns[other * kTurns + turn];
  }
}

float TurnScaleHistogram::MeanOfOthers(float log_scale, float turn, bool included) const {
  const int others = added_ - (included ? 1 : 0);
  if (others == 0) return 0.0f;
  // A similarity weighs 1 in its own cell.
  const float sum = smoothed_[CellOf(log_scale, turn)] - (included ? 1.0f : 0.0f);
  return std::max(sum, 0.0f) / static_cast<float>(others);
}

}  // namespace diffsac
