#include "diffsac/problem/neighborhood_features.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/geometry/vector_clones.h"
#include "diffsac/problem/neighbor_lanes.h"

namespace diffsac {
namespace {

constexpr int kNeighbors = kEight;
// Keep quotients finite where points coincide, and small distances from deciding.
constexpr float kLeastDistance = 1e-4f, kCoherenceDistance = 0.02f;
constexpr double kMostStretch = 4.0, kMostIncoherence = 100.0, kLeastIncoherence = 1e-3;

// kLanes matches and their neighbours, in the image where they are neighbours and in the other one.
struct Surroundings {
  LanePlaces here[2], there[2];
  LanePlaces neighbors_here[2][kNeighbors], neighbors_there[2][kNeighbors];
};

// Of each lane the product of the two middle quotients of distances (there over here), and the median incoherence.
DIFFSAC_VECTOR_CLONES
void Summarize(const Surroundings& around, double* __restrict quotients, double* __restrict incoherence) {
  LaneRow quotient[kNeighbors], apart[kNeighbors];
  for (int k = 0; k < kNeighbors; ++k) {
#pragma GCC unroll 1  // so that lanes become vectors
    for (int l = 0; l < kLanes; ++l) {
      const float hx = LaneStep(around.here[0][l], around.neighbors_here[0][k][l]);
      const float hy = LaneStep(around.here[1][l], around.neighbors_here[1][k][l]);
      const float tx = LaneStep(around.there[0][l], around.neighbors_there[0][k][l]);
      const float ty = LaneStep(around.there[1][l], around.neighbors_there[1][k][l]);
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

// What one image's neighbours of each match say. The columns end with whole groups of lanes.
struct View {
  Eigen::ArrayXd quotients, incoherence;
};

View MakeView(const PlanePoints& here, const PlanePoints& there, const std::vector<std::int32_t>& good,
              const std::vector<EightNearest>& neighbors) {
  const PlanePoints good_here = RowsOf(here, good), good_there = RowsOf(there, good);
  const auto count = static_cast<int>(here.size());
  const int padded = (count + kLanes - 1) / kLanes * kLanes;
  View view{Eigen::ArrayXd(padded), Eigen::ArrayXd(padded)};
  Surroundings around;
  for (int first = 0; first < count; first += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      const int match = std::min(first + l, count - 1);
      around.here[0][l] = here.x[match], around.here[1][l] = here.y[match];
      around.there[0][l] = there.x[match], around.there[1][l] = there.y[match];
      for (int k = 0; k < kNeighbors; ++k) {
        const std::int32_t other = neighbors[match][k];
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
                                                                                const GoodNeighbors& around) {
  const auto count = static_cast<std::int32_t>(coordinates.rows());
  Eigen::Matrix<float, Eigen::Dynamic, kNeighborhoodColumns> values(count, kNeighborhoodColumns);
  values.setZero();
  if (count <= kNeighbors) return values;
  const PlanePoints image1 = ImagePlane(coordinates, 0), image2 = ImagePlane(coordinates, 1);
  const auto& [nearest1, nearest2] = around.nearest;
  const View a = MakeView(image1, image2, around.good, nearest1), b = MakeView(image2, image1, around.good, nearest2);
  CountShared(nearest1.data(), nearest2.data(), count, values.col(0).data());
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
