#include "diffsac/geometry/epipolar.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "diffsac/geometry/least_eigenvector.h"
#include "diffsac/geometry/vector_clones.h"
#include "diffsac/geometry/weighted_pairs.h"

namespace diffsac {
Eigen::Vector3d LeftEpipole(const Eigen::Matrix3d& f) {
  Eigen::Vector3d epipole = f.col(0).cross(f.col(1));
  const Eigen::Vector3d others[] = {f.col(0).cross(f.col(2)), f.col(1).cross(f.col(2))};
  for (const Eigen::Vector3d& other : others)
    if (other.squaredNorm() > epipole.squaredNorm()) epipole = other;
  return epipole;
}

bool SatisfiesOrientation(const Eigen::Matrix3d& f, const double (*points)[4], int count) {
  const Eigen::Vector3d epipole = LeftEpipole(f);
  int positive = 0;
  for (int i = 0; i < count; ++i) {
    const double* p = points[i];
    const Eigen::Vector3d line = f.col(0) * p[0] + f.col(1) * p[1] + f.col(2);
    const Eigen::Vector3d through(epipole[1] - epipole[2] * p[3], epipole[2] * p[2] - epipole[0],
                                  epipole[0] * p[3] - epipole[1] * p[2]);
    positive += line.dot(through) > 0.0 ? 1 : 0;
    if (positive != 0 && positive != i + 1) return false;
  }
  return true;
}

DIFFSAC_VECTOR_CLONES
void SampsonDistances(const double* f, const double* const* columns, int begin, int end, double* out) {
  const double model[9] = {f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8]};
  const double *x1 = columns[0] + begin, *y1 = columns[1] + begin, *x2 = columns[2] + begin, *y2 = columns[3] + begin;
  double* __restrict distances = out;
  const int count = end - begin;
  for (int i = 0; i < count; ++i) distances[i] = SampsonDistance(model, x1[i], y1[i], x2[i], y2[i]);
}

Eigen::Matrix3d ClosestRankTwo(const Eigen::Matrix3d& f) {
  // F (I - v vᵀ) with v the right singular vector of the least singular value: rank 2 whatever the rounding of v.
  if (!f.allFinite()) return f;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(f.transpose() * f);
  const Eigen::Vector3d v = solver.eigenvectors().col(0);
  return f - (f * v) * v.transpose();
}

bool FitEpipolarMatrix(const PointMatrix& points, const Eigen::VectorXd& weights, PairNormalization* normalization,
                       Eigen::Matrix3d* f) {
  WeightedPairs pairs;
  if (!pairs.Gather(points, weights, 8)) return false;
  *normalization = pairs.normalization();
  // The rows x2 ⊗ x1 have the outer products (x2 x2ᵀ) ⊗ (x1 x1ᵀ): 6 times 6 different numbers.
  const Eigen::Matrix<double, 6, 6> sums = pairs.EpipolarMoments();
  constexpr int kPair[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  Eigen::Matrix<double, 9, 9> moments;
  for (int row = 0; row < 9; ++row)
    for (int column = 0; column < 9; ++column)
      moments(row, column) = sums(kPair[row / 3][column / 3], kPair[row % 3][column % 3]);
  Matrix3Parameters solution;
  if (!LeastEigenvector(moments, &solution)) return false;
  *f = AsMatrix(solution);
  return true;
}

}  // namespace diffsac
