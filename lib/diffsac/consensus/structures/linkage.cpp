#include "diffsac/consensus/structures/linkage.h"

#include <limits>

namespace diffsac {
namespace {

constexpr float kNothingInCommon = 1.0f;

class Linkage {
 public:
  explicit Linkage(const PreferenceMatrix& preferences)
      : preferences_(preferences),
        squares_(preferences_.rowwise().squaredNorm()),
        cluster_(static_cast<std::size_t>(preferences_.rows())),
        alive_(cluster_.size(), true),
        nearest_(cluster_.size()) {
    for (int i = 0; i < size(); ++i) cluster_[i] = i;
    for (int i = 0; i < size(); ++i) nearest_[i] = FindNearest(i);
  }

  std::vector<int> Run() {
    for (int a = Closest(); a >= 0; a = Closest()) Merge(a, nearest_[a].other);
    return Numbered();
  }

 private:
  // The nearest cluster behind one (of a higher number), so that each pair stands once.
  struct Neighbor {
    float distance = kNothingInCommon;
    int other = -1;
  };

  int size() const { return static_cast<int>(cluster_.size()); }

  float Distance(int a, int b) const {
    const float common = preferences_.row(a).dot(preferences_.row(b));
    if (common <= 0.0f) return kNothingInCommon;
    return 1.0f - common / (squares_[a] + squares_[b] - common);
  }

  Neighbor FindNearest(int a) const {
    Neighbor nearest;
    for (int b = a + 1; b < size(); ++b) {
      if (!alive_[b]) continue;
      const float distance = Distance(a, b);
      if (distance < nearest.distance) nearest = {distance, b};
    }
    return nearest;
  }

  int Closest() const {
    int closest = -1;
    float least = kNothingInCommon;
    for (int a = 0; a < size(); ++a)
      if (alive_[a] && nearest_[a].distance < least) least = nearest_[closest = a].distance;
    return closest;
  }

  void Merge(int a, int b) {
    preferences_.row(a) = preferences_.row(a).cwiseMin(preferences_.row(b));
    squares_[a] = preferences_.row(a).squaredNorm();
    alive_[b] = false;
    for (int& cluster : cluster_)
      if (cluster == b) cluster = a;
    nearest_[a] = FindNearest(a);
    for (int c = 0; c < b; ++c) {
      if (!alive_[c] || c == a) continue;
      if (nearest_[c].other == a || nearest_[c].other == b) {
        nearest_[c] = FindNearest(c);
      } else if (c < a) {
        const float distance = Distance(c, a);
        if (distance < nearest_[c].distance) nearest_[c] = {distance, a};
      }
    }
  }

  std::vector<int> Numbered() const {
    std::vector<int> number(cluster_.size(), -1), result;
    int count = 0;
    for (const int cluster : cluster_) {
      if (number[cluster] < 0) number[cluster] = count++;
      result.push_back(number[cluster]);
    }
    return result;
  }

  PreferenceMatrix preferences_;
  Eigen::VectorXf squares_;
  std::vector<int> cluster_;  // of each point: the cluster's first point
  std::vector<bool> alive_;
  std::vector<Neighbor> nearest_;
};

}  // namespace

std::vector<int> LinkPoints(const PreferenceMatrix& preferences) { return Linkage(preferences).Run(); }

}  // namespace diffsac
