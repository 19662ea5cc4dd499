#pragma once

#include <Eigen/Core>
#include <vector>

#include "diffsac/geometry/points.h"

namespace diffsac {

/// The vanishing points among which a network chooses, best first by the length that supports them: of many hypotheses
/// those of most support and those of most support among the segments that earlier ones leave, refined, no two within
/// 1° of each other; and the third direction orthogonal to each nearly orthogonal two of the best, since rooms and
/// streets have such.
struct VanishingPointPool {
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<Eigen::Vector3d> models;
  Rows features;  ///< H × kPoolFeatures: of each model.
  Rows pairs;     ///< H² × kPoolPairs, row i·H + j: of each two.
};

/// At most so many models in a pool.
inline constexpr int kPoolSize = 64;
inline constexpr int kPoolFeatures = 42;
/// So many of the features, the last ones, change sign when the image is mirrored left to right.
inline constexpr int kPoolOddFeatures = 2;
inline constexpr int kPoolPairs = 9;

/// points: N × 4 segments in normalised coordinates; lengths: N, in pixels over half the image's longer side;
/// hypotheses: vanishing points that were solved for.
VanishingPointPool MakeVanishingPointPool(const PointMatrix& points, const Eigen::VectorXd& lengths,
                                          const std::vector<Eigen::Vector3d>& hypotheses);

/// Vanishing points refined on all segments, which count by the cube of their lengths: long ones are sure of their
/// direction, and are what people mean.
std::vector<ModelParameters> RefineOnLongest(const PointMatrix& points, const Eigen::VectorXd& lengths,
                                             const std::vector<Eigen::Vector3d>& models);

}  // namespace diffsac
