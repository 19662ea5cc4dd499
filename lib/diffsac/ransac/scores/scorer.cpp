#include "diffsac/ransac/scores/scorer.h"

#include <numeric>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

constexpr int kClasses = 4;
/// So many points in random order are enough for a test, and a permutation of millions would cost more than it saves.
constexpr int kMostMixed = 2048;

int ClassOf(double weight) { return weight > 0.5 ? 0 : weight > 0.25 ? 1 : weight > 0.125 ? 2 : 3; }

/// Exchanges each of the first `count` rows with one from there on.
void MixFirst(int count, int size, Rng* rng, int* rows) {
  for (int i = 0; i < count; ++i) std::swap(rows[i], rows[i + static_cast<int>(rng->Below(size - i))]);
}

}  // namespace

ScorePrior ScorePrior::Of(const std::vector<int>& rows) const {
  ScorePrior some{{}, cameras, {}, keypoint_orientation_weight};
  if (weights.size() > 0) some.weights = weights(rows);
  if (turns.rows() > 0) some.turns = turns(rows, Eigen::all);
  return some;
}

RowsByWeight SortByWeight(int size, const Eigen::VectorXd& weights) {
  RowsByWeight result;
  std::array<int, kClasses + 1> place{};
  const auto class_of = [&](int i) { return weights.size() == 0 ? 0 : ClassOf(weights[i]); };
  for (int i = 0; i < size; ++i) ++place[class_of(i) + 1];
  std::partial_sum(place.begin(), place.end(), place.begin());
  const std::array<int, kClasses + 1> first = place;
  result.rows.resize(size);
  for (int i = 0; i < size; ++i) result.rows[place[class_of(i)]++] = i;
  Rng rng = Rng().Fork("rows by weight");
  for (int c = 0; c < kClasses; ++c) {
    const int begin = first[c], end = first[c + 1], mixed = std::min(end, begin + kMostMixed);
    if (begin == end) continue;
    MixFirst(mixed - begin, end - begin, &rng, result.rows.data() + begin);
    result.classes.push_back({begin, mixed, end, std::ldexp(1.0, -c)});
  }
  return result;
}

}  // namespace diffsac
