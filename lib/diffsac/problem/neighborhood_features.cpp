#include "diffsac/problem/neighborhood_features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "diffsac/geometry/vector_clones.h"
#include "diffsac/problem/nearest_eight.h"

namespace diffsac {
namespace {

constexpr int kNeighbors = kEight, kFewestGood = 16;
// Matches whose figures are reckoned together, each in a lane of a vector.
constexpr int kLanes = 8;
// Keep quotients finite where points coincide, and small distances from deciding.
constexpr float kLeastDistance = 1e-4f, kCoherenceDistance = 0.02f;
constexpr double kMostStretch = 4.0, kMostIncoherence = 100.0, kLeastIncoherence = 1e-3;
// A longer step counts as this one, whose square single precision holds.
constexpr double kFarthest = 1e15;

// Rows of the matches of lowest ratio, ascending.
std::vector<std::int32_t> GoodMatches(std::int32_t count, const Eigen::VectorXd& quality) {
  const bool known = quality.size() == count;
  std::vector<std::pair<double, std::int32_t>> ranked(count);
  for (std::int32_t i = 0; i < count; ++i) {
    const double ratio = known ? quality[i] : 0.0;
    // NaN ranks last.
    ranked[i] = {std::isnan(ratio) ? std::numeric_limits<double>::infinity() : ratio, i};
  }
  const std::int32_t kept = known ? std::min(count, std::max(kFewestGood, count / 4)) : count;
  if (kept < count) std::nth_element(ranked.begin(), ranked.begin() + kept, ranked.end());
  std::vector<std::int32_t> good(kept);
  for (std::int32_t i = 0; i < kept; ++i) good[i] = ranked[i].second;
  std::sort(good.begin(), good.end());
  return good;
}

// Coordinates of one image, a column each.
PlanePoints ImagePlane(const PointMatrix& coordinates, int image) {
  PlanePoints plane(coordinates.rows());
  for (Eigen::Index i = 0; i < coordinates.rows(); ++i) {
    plane.x[i] = coordinates(i, 2 * image);
    plane.y[i] = coordinates(i, 2 * image + 1);
  }
  return plane;
}

PlanePoints RowsOf(const PlanePoints& plane, const std::vector<std::int32_t>& rows) {
  PlanePoints chosen(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) chosen.x[i] = plane.x[rows[i]], chosen.y[i] = plane.y[rows[i]];
  return chosen;
}

// One value a lane; what is done to rows is done to whole vectors.
using Row = float[kLanes];
using Places = double[kLanes];

// kLanes matches and their neighbours, in the image where they are neighbours and in the other one.
struct Surroundings {
  Places here[2], there[2];
  Places neighbors_here[2][kNeighbors], neighbors_there[2][kNeighbors];
};

// Rounded only as a difference; inlined into loops over lanes.
inline float Step(double from, double to) {
  const double step = to - from;
  const double most = step < kFarthest ? step : kFarthest;
  return static_cast<float>(most > -kFarthest ? most : -kFarthest);
}

inline void Order(Row& a, Row& b) {
  for (int l = 0; l < kLanes; ++l) {
    const float first = a[l], second = b[l];
    a[l] = first < second ? first : second;
    b[l] = first > second ? first : second;
  }
}

// Brings the two middle ones of eight to places 3 and 4.
inline void SortMiddle(Row* v) {
  Order(v[0], v[2]), Order(v[1], v[3]), Order(v[4], v[6]), Order(v[5], v[7]);
  Order(v[0], v[4]), Order(v[1], v[5]), Order(v[2], v[6]), Order(v[3], v[7]);
  Order(v[0], v[1]), Order(v[2], v[3]), Order(v[4], v[5]), Order(v[6], v[7]);
  Order(v[2], v[4]), Order(v[3], v[5]);
  Order(v[1], v[4]), Order(v[3], v[6]);
  Order(v[3], v[4]);
}

// Of each lane the product of the two middle quotients of distances (there over here), and the median incoherence.
DIFFSAC_VECTOR_CLONES
void Summarize(const Surroundings& around, double* __restrict quotients, double* __restrict incoherence) {
  Row quotient[kNeighbors], apart[kNeighbors];
  for (int k = 0; k < kNeighbors; ++k) {
#pragma GCC unroll 1  // so that lanes become vectors
    for (int l = 0; l < kLanes; ++l) {
      const float hx = Step(around.here[0][l], around.neighbors_here[0][k][l]);
      const float hy = Step(around.here[1][l], around.neighbors_here[1][k][l]);
      const float tx = Step(around.there[0][l], around.neighbors_there[0][k][l]);
      const float ty = Step(around.there[1][l], around.neighbors_there[1][k][l]);
      const float here = std::sqrt(hx * hx + hy * hy), there = std::sqrt(tx * tx + ty * ty);
      const float dx = tx - hx, dy = ty - hy;
      quotient[k][l] = (there + kLeastDistance) / (here + kLeastDistance);
      apart[k][l] = std::sqrt(dx * dx + dy * dy) / (here + kCoherenceDistance);
    }
  }
  SortMiddle(quotient);
  SortMiddle(apart);
  for (int l = 0; l < kLanes; ++l) {
    quotients[l] = static_cast<double>(quotient[3][l]) * quotient[4][l];
    incoherence[l] = 0.5 * (static_cast<double>(apart[3][l]) + apart[4][l]);
  }
}

// One image's neighbours of each match, and what they say. The columns end with whole groups of lanes.
struct View {
  std::vector<EightNearest> neighbors;  // numbers among the good matches
  Eigen::ArrayXd quotients, incoherence;
};

View MakeView(const PlanePoints& here, const PlanePoints& there, const std::vector<std::int32_t>& good,
              const std::vector<std::int32_t>& own) {
  const PlanePoints good_here = RowsOf(here, good), good_there = RowsOf(there, good);
  const auto count = static_cast<int>(here.size());
  const int padded = (count + kLanes - 1) / kLanes * kLanes;
  View view{NearestEight(good_here, here, own), Eigen::ArrayXd(padded), Eigen::ArrayXd(padded)};
  Surroundings around;
  for (int first = 0; first < count; first += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      const int match = std::min(first + l, count - 1);
      around.here[0][l] = here.x[match], around.here[1][l] = here.y[match];
      around.there[0][l] = there.x[match], around.there[1][l] = there.y[match];
      for (int k = 0; k < kNeighbors; ++k) {
        const std::int32_t other = view.neighbors[match][k];
        around.neighbors_here[0][k][l] = good_here.x[other], around.neighbors_here[1][k][l] = good_here.y[other];
        around.neighbors_there[0][k][l] = good_there.x[other], around.neighbors_there[1][k][l] = good_there.y[other];
      }
    }
    Summarize(around, view.quotients.data() + first, view.incoherence.data() + first);
  }
  return view;
}

// How many of their neighbours the two images share, match by match.
DIFFSAC_VECTOR_CLONES
void CountShared(const EightNearest* a, const EightNearest* b, int count, float* shared) {
  for (int i = 0; i < count; ++i) {
    std::int32_t equal[kNeighbors] = {};
    for (int j = 0; j < kNeighbors; ++j)
      for (int k = 0; k < kNeighbors; ++k) equal[k] += a[i][j] == b[i][k] ? 1 : 0;
    std::int32_t sum = 0;
    for (int k = 0; k < kNeighbors; ++k) sum += equal[k];
    shared[i] = static_cast<float>(sum) / kNeighbors;
  }
}

}  // namespace

Eigen::Matrix<float, Eigen::Dynamic, kNeighborhoodColumns> NeighborhoodFeatures(const PointMatrix& coordinates,
                                                                                const Eigen::VectorXd& quality) {
  const auto count = static_cast<std::int32_t>(coordinates.rows());
  Eigen::Matrix<float, Eigen::Dynamic, kNeighborhoodColumns> values(count, kNeighborhoodColumns);
  values.setZero();
  if (count <= kNeighbors) return values;
  const std::vector<std::int32_t> good = GoodMatches(count, quality);
  std::vector<std::int32_t> own(count, -1);
  for (std::size_t i = 0; i < good.size(); ++i) own[good[i]] = static_cast<std::int32_t>(i);
  const PlanePoints image1 = ImagePlane(coordinates, 0), image2 = ImagePlane(coordinates, 1);
  const View a = MakeView(image1, image2, good, own), b = MakeView(image2, image1, good, own);
  CountShared(a.neighbors.data(), b.neighbors.data(), count, values.col(0).data());
  // Medians are means of two logarithms, and the views' mean is taken: a quarter of the logarithm of the product.
  // Whole SIMD packets only: a value must not depend on where in the array its match stands.
  const Eigen::ArrayXd stretch = (0.25 * (a.quotients * b.quotients).log()).max(-kMostStretch).min(kMostStretch);
  const Eigen::ArrayXd incoherence =
      ((0.5 * (a.incoherence + b.incoherence)).min(kMostIncoherence) + kLeastIncoherence).log();
  values.col(1) = (0.5 * stretch.head(count)).cast<float>();
  values.col(2) = ((2.0 + incoherence.head(count)) / 3.0).cast<float>();
  return values;
}

}  // namespace diffsac
