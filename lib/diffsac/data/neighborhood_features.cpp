#include "diffsac/data/neighborhood_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "diffsac/consensus/neighbor_index.h"

namespace diffsac {
namespace {

constexpr int kNeighbors = 8, kFewestGood = 16;
// Keep quotients finite where points coincide, and small distances from deciding.
constexpr double kLeastDistance = 1e-4, kCoherenceDistance = 0.02;
constexpr double kMostStretch = 4.0, kMostIncoherence = 100.0, kLeastIncoherence = 1e-3;

std::vector<int> GoodMatches(Eigen::Index count, const Eigen::VectorXd& quality) {
  std::vector<int> good(count);
  std::iota(good.begin(), good.end(), 0);
  if (quality.size() != count) return good;
  // NaN ranks last.
  const auto ratio = [&](int i) {
    return std::isnan(quality[i]) ? std::numeric_limits<double>::infinity() : quality[i];
  };
  std::stable_sort(good.begin(), good.end(), [&](int a, int b) { return ratio(a) < ratio(b); });
  good.resize(std::min<std::size_t>(good.size(), std::max<std::size_t>(kFewestGood, good.size() / 4)));
  return good;
}

// The neighbours of one match in one image, and how they lie in both.
struct Surroundings {
  std::array<int, kNeighbors> neighbors;
  double stretch = 0.0;  // median log of the distance in the other image over that in this one
  double incoherence = 0.0;
};

double MedianOf(std::array<double, kNeighbors> values) {
  std::sort(values.begin(), values.end());
  return 0.5 * (values[kNeighbors / 2 - 1] + values[kNeighbors / 2]);
}

class View {
 public:
  View(const PointMatrix& coordinates, const std::vector<int>& good, int image)
      : coordinates_(coordinates), good_(good), image_(image), index_(Columns(coordinates, good, image)) {}

  Surroundings Of(int match) const {
    const Eigen::RowVector4d point = coordinates_.row(match);
    const Eigen::RowVector2d here = point.segment<2>(2 * image_), there = point.segment<2>(2 - 2 * image_);
    Surroundings around;
    std::array<double, kNeighbors> stretch, incoherence;
    int count = 0;
    // One more than asked for, since a good match finds itself.
    for (int found : index_.NearestTo(here.data(), kNeighbors + 1)) {
      const int other = good_[found];
      if (other == match || count == kNeighbors) continue;
      const Eigen::RowVector4d neighbor = coordinates_.row(other);
      const Eigen::RowVector2d step = neighbor.segment<2>(2 * image_) - here;
      const Eigen::RowVector2d other_step = neighbor.segment<2>(2 - 2 * image_) - there;
      stretch[count] = std::log((other_step.norm() + kLeastDistance) / (step.norm() + kLeastDistance));
      incoherence[count] = (other_step - step).norm() / (step.norm() + kCoherenceDistance);
      around.neighbors[count++] = other;
    }
    around.stretch = MedianOf(stretch);
    around.incoherence = MedianOf(incoherence);
    return around;
  }

 private:
  static PointMatrix Columns(const PointMatrix& coordinates, const std::vector<int>& rows, int image) {
    return coordinates(rows, Eigen::seqN(2 * image, 2));
  }

  const PointMatrix& coordinates_;
  const std::vector<int>& good_;
  int image_;
  NeighborIndex index_;
};

int Shared(const Surroundings& a, const Surroundings& b) {
  int shared = 0;
  for (int i : a.neighbors) shared += std::find(b.neighbors.begin(), b.neighbors.end(), i) != b.neighbors.end() ? 1 : 0;
  return shared;
}

}  // namespace

Eigen::Matrix<float, Eigen::Dynamic, kNeighborhoodColumns> NeighborhoodFeatures(const PointMatrix& coordinates,
                                                                                const Eigen::VectorXd& quality) {
  const auto count = static_cast<int>(coordinates.rows());
  Eigen::Matrix<float, Eigen::Dynamic, kNeighborhoodColumns> values(count, kNeighborhoodColumns);
  values.setZero();
  if (count <= kNeighbors) return values;
  const std::vector<int> good = GoodMatches(count, quality);
  const View view1(coordinates, good, 0), view2(coordinates, good, 1);
  for (int i = 0; i < count; ++i) {
    const Surroundings a = view1.Of(i), b = view2.Of(i);
    const double stretch = std::clamp(0.5 * (a.stretch + b.stretch), -kMostStretch, kMostStretch);
    const double incoherence = std::min(0.5 * (a.incoherence + b.incoherence), kMostIncoherence);
    values(i, 0) = static_cast<float>(Shared(a, b)) / kNeighbors;
    values(i, 1) = static_cast<float>(0.5 * stretch);
    values(i, 2) = static_cast<float>((2.0 + std::log(incoherence + kLeastIncoherence)) / 3.0);
  }
  return values;
}

}  // namespace diffsac
