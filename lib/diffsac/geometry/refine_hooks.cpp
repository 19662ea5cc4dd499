// The models' Refine: Levenberg-Marquardt with the truncated loss, as the sample-consensus loop asks for it.

#include <cmath>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/refine.h"

namespace diffsac {
namespace {

/// Points beyond this many thresholds sit out, for speed.
constexpr double kReach = 3.0;

template <class Model>
Eigen::VectorXd Residuals(const PointMatrix& points, const Matrix3Parameters& model) {
  Eigen::VectorXd residuals(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) residuals[i] = Model::Residual(model, points.data() + 4 * i);
  return residuals;
}

/// Of all points, those that sit out too.
double TruncatedCost(const Eigen::VectorXd& residuals, const RobustLoss& loss) {
  double sum = 0.0;
  for (const double residual : residuals) sum += loss.Value(residual * residual);
  return sum;
}

/// refine: (points, weights, options, model) -> RefineReport.
template <class Model, class RefineModel>
bool RefineTruncated(const PointMatrix& points, double threshold, const RefineModel& refine, Matrix3Parameters* model) {
  if (points.cols() != 4 || !(threshold > 0.0) || !std::isfinite(threshold) || !model->allFinite()) return false;
  RefineOptions options;
  options.loss = {LossKind::kTruncated, threshold};
  const Eigen::VectorXd before = Residuals<Model>(points, *model);
  Matrix3Parameters refined = *model;
  refine(points, (before.array() <= kReach * threshold).template cast<double>(), options, &refined);
  if (refined == *model || !refined.allFinite()) return false;
  // Counted again in the points' own coordinates: near a minimum the refinement's gain may be its rounding.
  const Eigen::VectorXd after = Residuals<Model>(points, refined);
  if (!(TruncatedCost(after, options.loss) < TruncatedCost(before, options.loss))) return false;
  *model = refined;
  return true;
}

}  // namespace

bool Homography::Refine(const PointMatrix& points, double threshold, Parameters* model) {
  const auto refine = [](const auto& p, const auto& weights, const auto& options, Parameters* m) {
    return RefineHomography(p, weights, options, HomographyError::kSymmetricTransfer, m);
  };
  return RefineTruncated<Homography>(points, threshold, refine, model);
}

bool Fundamental::Refine(const PointMatrix& points, double threshold, Parameters* model) {
  return RefineTruncated<Fundamental>(points, threshold, RefineFundamental, model);
}

bool Essential::Refine(const PointMatrix& points, double threshold, Parameters* model) {
  return RefineTruncated<Essential>(points, threshold, RefineEssential, model);
}

}  // namespace diffsac
