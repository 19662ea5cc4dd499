#include "lab/baselines/density_guide.h"

#include <algorithm>

namespace diffsac {
namespace {

bool Contains(const int* set, int size, int value) { return std::find(set, set + size, value) != set + size; }

/// A point with probability in proportion to its weight; total: their sum, positive.
int DrawWeighted(const Eigen::VectorXd& weights, double total, Rng& rng) {
  double left = rng.Uniform() * total;
  int last = -1;
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    if (!(weights[i] > 0.0)) continue;
    last = static_cast<int>(i);
    left -= weights[i];
    if (left < 0.0) break;
  }
  return last;
}

int DrawOther(int num_points, const int* set, int taken, Rng& rng) {
  int point = -1;
  do {
    point = static_cast<int>(rng.Below(static_cast<std::uint64_t>(num_points)));
  } while (Contains(set, taken, point));
  return point;
}

}  // namespace

DensityGuide::DensityGuide(int num_points, int preferred)
    : preferred_(preferred), preferences_(num_points), round_(num_points), weights_(num_points) {}

void DensityGuide::Add(const Eigen::VectorXd& density) {
  const int hypothesis = hypotheses_++;
  for (int i = 0; i < num_points(); ++i) {
    std::vector<Preference>& own = preferences_[i];
    const bool full = static_cast<int>(own.size()) == preferred_;
    if (!(density[i] > 0.0) || (full && density[i] <= own.back().density)) continue;
    const auto place =
        std::find_if(own.begin(), own.end(), [&](const Preference& other) { return density[i] > other.density; });
    own.insert(place, {density[i], hypothesis});
    if (static_cast<int>(own.size()) > preferred_) own.pop_back();
  }
}

double DensityGuide::Explanation(int point) const {
  double sum = 0.0;
  for (const Preference& preference : preferences_[point]) sum += preference.density;
  return sum;
}

std::vector<int> DensityGuide::Preferred() const {
  std::vector<char> is_preferred(hypotheses_, 0);
  for (const auto& own : preferences_)
    for (const Preference& preference : own) is_preferred[preference.hypothesis] = 1;
  std::vector<int> result;
  for (int h = 0; h < hypotheses_; ++h)
    if (is_preferred[h]) result.push_back(h);
  return result;
}

void DensityGuide::StartRound() {
  supporters_.assign(hypotheses_, {});
  for (int i = 0; i < num_points(); ++i) {
    round_[i].clear();
    for (const Preference& preference : preferences_[i]) {
      round_[i].push_back(preference.hypothesis);
      supporters_[preference.hypothesis].push_back(i);
    }
  }
}

void DensityGuide::Draw(int first, int size, Rng& rng, int* set) {
  weights_.setZero();
  for (const int hypothesis : round_[first])
    for (const int point : supporters_[hypothesis]) weights_[point] += 1.0 / preferred_;
  set[0] = first;
  weights_[first] = 0.0;
  for (int taken = 1; taken < size; ++taken) {
    const double total = weights_.sum();
    set[taken] = total > 0.0 ? DrawWeighted(weights_, total, rng) : DrawOther(num_points(), set, taken, rng);
    weights_[set[taken]] = 0.0;
  }
  std::sort(set, set + size);
}

}  // namespace diffsac
