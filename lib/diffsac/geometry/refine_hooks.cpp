// The models' Refine: Levenberg-Marquardt with a robust loss, as the sample-consensus loop asks for it.

#include <cmath>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/geometry/robust_loss_sums.h"
#include "diffsac/geometry/row_residuals.h"

namespace diffsac {
namespace {

/// A gain of this share of the cost moves a model of a thousand points by a thirtieth of its standard deviation.
constexpr double kTolerance = 1e-6;

template <class Model>
Eigen::VectorXd Residuals(const PointMatrix& points, const Matrix3Parameters& model) {
  Eigen::VectorXd residuals(points.rows());
  RowResiduals<Model>(points, model, residuals.data());
  return residuals;
}

/// Of all points, those that sit out too.
double Cost(const Eigen::VectorXd& residuals, const Eigen::VectorXd& weights, const RobustLoss& loss) {
  return SumLoss(loss, residuals.data(), weights.data(), static_cast<int>(residuals.size()));
}

/// refine: (points, weights, options, model) -> RefineReport.
template <class Model, class RefineModel>
bool RefineRobustly(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss, int steps,
                    const RefineModel& refine, Matrix3Parameters* model) {
  if (points.cols() != 4 || weights.size() != points.rows() || !(loss.scale > 0.0) || !std::isfinite(loss.scale) ||
      !model->allFinite())
    return false;
  RefineOptions options;
  options.loss = loss;
  options.max_iterations = steps;
  options.relative_tolerance = kTolerance;
  const Eigen::VectorXd before = Residuals<Model>(points, *model);
  Matrix3Parameters refined = *model;
  const Eigen::VectorXd near = (before.array() <= kRefineReach * loss.scale).template cast<double>();
  refine(points, near.cwiseProduct(weights), options, &refined);
  if (refined == *model || !refined.allFinite()) return false;
  // Counted again in the points' own coordinates: near a minimum the refinement's gain may be its rounding.
  const Eigen::VectorXd after = Residuals<Model>(points, refined);
  if (!(Cost(after, weights, loss) < Cost(before, weights, loss))) return false;
  *model = refined;
  return true;
}

/// Each point alike, with the truncated loss.
template <class Model>
bool RefineTruncated(const PointMatrix& points, double threshold, Matrix3Parameters* model) {
  return Model::Refine(points, Eigen::VectorXd::Ones(points.rows()), {LossKind::kTruncated, threshold}, model);
}

}  // namespace

bool Homography::Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                        Parameters* model, int steps) {
  return RefineRobustly<Homography>(points, weights, loss, steps, RefineHomography, model);
}

bool Fundamental::Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                         Parameters* model, int steps) {
  return RefineRobustly<Fundamental>(points, weights, loss, steps, RefineFundamental, model);
}

bool Essential::Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                       Parameters* model, int steps) {
  return RefineRobustly<Essential>(points, weights, loss, steps, RefineEssential, model);
}

bool Essential::FitFrom(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* model) {
  RefineOptions options;
  options.loss = {LossKind::kTrivial};
  // Far below what noise leaves of the squares: who fits again chooses the points anew, and most fits are of samples.
  options.max_iterations = 2;
  options.relative_tolerance = 1e-3;
  return RefineEssential(points, weights, options, model).status == Status::kOk;
}

bool Homography::Refine(const PointMatrix& points, double threshold, Parameters* model) {
  return RefineTruncated<Homography>(points, threshold, model);
}

bool Fundamental::Refine(const PointMatrix& points, double threshold, Parameters* model) {
  return RefineTruncated<Fundamental>(points, threshold, model);
}

bool Essential::Refine(const PointMatrix& points, double threshold, Parameters* model) {
  return RefineTruncated<Essential>(points, threshold, model);
}

}  // namespace diffsac
