#include "diffsac/train/consensus_loss.h"

#include <torch/torch.h>

#include <Eigen/LU>

#include <cmath>

#include "diffsac/geometry/two_view.h"
#include "diffsac/methods/solver_space.h"

namespace diffsac {
namespace {

// Ridge and gap, relative to the trace, below which a smallest eigenvector is left alone: its derivative has the gap in
// the denominator.
constexpr double kLeastGap = 1e-7;

torch::Tensor ToTensor(const PointMatrix& matrix) {
  return torch::from_blob(const_cast<double*>(matrix.data()), {matrix.rows(), matrix.cols()}, torch::kDouble).clone();
}

torch::Tensor UnitVector(const Eigen::VectorXd& vector) {
  if (!vector.allFinite() || !(vector.norm() > 0.0)) return {};
  const Eigen::VectorXd unit = vector.normalized();
  return torch::from_blob(const_cast<double*>(unit.data()), {unit.size()}, torch::kDouble).clone();
}

// Centroid to the origin, root mean square distance to √2.
Eigen::Matrix3d Normalization(const PointMatrix& points, int first) {
  const Eigen::RowVector2d mean = points.middleCols(first, 2).colwise().mean();
  const double spread =
      std::sqrt((points.middleCols(first, 2).rowwise() - mean).squaredNorm() / static_cast<double>(points.rows()));
  const double scale = spread > 0.0 ? std::sqrt(2.0) / spread : 1.0;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 0) = matrix(1, 1) = scale;
  matrix(0, 2) = -scale * mean.x();
  matrix(1, 2) = -scale * mean.y();
  return matrix;
}

LinearFit HyperplaneFit(const Example& example) {
  const PointMatrix& points = example.problem.points;
  const Eigen::RowVectorXd mean = points.colwise().mean();
  PointMatrix rows = points.rowwise() - mean;
  const double spread = std::sqrt(rows.squaredNorm() / static_cast<double>(rows.rows()));
  if (spread > 0.0) rows /= spread;
  LinearFit fit{ToTensor(rows), 1, {}};
  if (example.truth.model.size() == points.cols() + 1) fit.truth = UnitVector(example.truth.model.head(points.cols()));
  return fit;
}

LinearFit TwoViewFit(const Example& example) {
  const SolverSpace space(example.problem);
  const PointMatrix& points = space.points();
  const Eigen::Matrix3d first = Normalization(points, 0), second = Normalization(points, 2);
  const bool homography = example.problem.task == Task::kHomography;
  PointMatrix rows = PointMatrix::Zero(homography ? 2 * points.rows() : points.rows(), 9);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector3d a = first * Eigen::Vector3d(points(i, 0), points(i, 1), 1.0);
    const Eigen::Vector3d b = second * Eigen::Vector3d(points(i, 2), points(i, 3), 1.0);
    if (homography) {
      rows.row(2 * i) << 0.0, 0.0, 0.0, -a.transpose(), b.y() * a.transpose();
      rows.row(2 * i + 1) << a.transpose(), 0.0, 0.0, 0.0, -b.x() * a.transpose();
    } else {
      rows.row(i) << b.x() * a.transpose(), b.y() * a.transpose(), a.transpose();
    }
  }
  LinearFit fit{ToTensor(rows), homography ? 2 : 1, {}};
  if (example.truth.model.size() != 9) return fit;
  const Eigen::Matrix3d model = AsMatrix(example.truth.model);
  const Eigen::Matrix3d normalized = homography
                                         ? Eigen::Matrix3d(second * model * first.inverse())
                                         : Eigen::Matrix3d(second.inverse().transpose() * model * first.inverse());
  fit.truth = UnitVector(AsParameters(normalized));
  return fit;
}

// The unit vector of least Σ w (row · v)²; *determined is false where it is not one.
torch::Tensor SmallestVector(const torch::Tensor& scatter, bool* determined) {
  const auto size = scatter.size(0);
  const auto trace = scatter.diagonal().sum();
  *determined = false;
  if (!(trace.item<double>() > 0.0)) return {};
  const auto [values, vectors] = torch::linalg_eigh(scatter / trace);
  *determined = (values[1] - values[0]).item<double>() > kLeastGap;
  return vectors.select(1, 0).view({size});
}

}  // namespace

torch::Tensor AdaptiveTemperature(const torch::Tensor& distances, const torch::Tensor& inliers, double alpha) {
  const auto cooled = torch::exp(-(1.0 - distances.clamp(0.0, 1.0)) / alpha);
  return torch::where(inliers > 0.5, cooled, torch::ones_like(cooled));
}

torch::Tensor BalancedCrossEntropy(const torch::Tensor& logits, const torch::Tensor& inliers,
                                   const torch::Tensor& temperature, const torch::Tensor& mask) {
  const auto real = mask.to(logits.dtype());
  const auto each = torch::binary_cross_entropy_with_logits(logits.masked_fill(mask.logical_not(), 0.0) * temperature,
                                                            inliers, {}, {}, torch::Reduction::None);
  const auto mean = [&](const torch::Tensor& of) { return (each * of).sum(1) / of.sum(1).clamp_min(1.0); };
  return 0.5 * (mean(inliers * real) + mean((1.0 - inliers) * real)).mean();
}

LinearFit MakeLinearFit(const Example& example) {
  return IsTwoView(example.problem.task) ? TwoViewFit(example) : HyperplaneFit(example);
}

torch::Tensor RegressionLoss(const torch::Tensor& weights, const std::vector<LinearFit>& fits, bool about_mean) {
  torch::Tensor total = torch::zeros({}, torch::kDouble);
  int count = 0;
  const auto all = weights.to(torch::kCPU, torch::kDouble);
  for (std::size_t b = 0; b < fits.size(); ++b) {
    if (!fits[b].truth.defined()) continue;
    ++count;
    auto rows = fits[b].rows;
    const auto points = rows.size(0) / fits[b].rows_per_point;
    const auto w =
        all[static_cast<std::int64_t>(b)].slice(0, 0, points).repeat_interleave(fits[b].rows_per_point).unsqueeze(1);
    if (about_mean) rows = rows - (w * rows).sum(0, true) / w.sum().clamp_min(1e-9);
    bool determined = false;
    const auto vector = SmallestVector(torch::matmul(rows.t(), w * rows), &determined);
    if (determined) total = total + 1.0 - vector.dot(fits[b].truth).square();
  }
  return total / std::max(count, 1);
}

}  // namespace diffsac
