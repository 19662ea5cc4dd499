#include "diffsac/geometry/shared_focal.h"

#include <cmath>

#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/refine.h"

namespace diffsac {
namespace {

Eigen::Matrix3d CameraOf(double focal) { return Eigen::DiagonalMatrix<double, 3>(focal, focal, 1.0); }

Eigen::Matrix3d FirstCamera(UnknownFocal unknown, double focal) {
  return CameraOf(unknown == UnknownFocal::kBoth ? focal : 1.0);
}

void CalibratedPoints(UnknownFocal unknown, double focal, const double (*points)[4], int count, double (*out)[4]) {
  for (int i = 0; i < count; ++i) DivideByFocal(unknown, focal, points[i], out[i]);
}

/// Whether all points can lie before both cameras.
bool IsPossible(UnknownFocal unknown, const FocalParameters& model, const double (*points)[4], int count) {
  double calibrated[6][4];
  CalibratedPoints(unknown, model[9], points, count, calibrated);
  const Eigen::Matrix3d e = AsMatrix(model.head<9>());
  return SatisfiesOrientation(e, calibrated, count) && SatisfiesCheirality(e, calibrated, count);
}

/// The f with which F makes the matrix nearest to an essential one; a coarse search in log f, then a finer one.
double FocalOf(UnknownFocal unknown, const Matrix3Parameters& f) {
  const auto mismatch = [&](double log_focal) {
    const double focal = std::exp(log_focal);
    return Fundamental::CameraMismatch(f, FirstCamera(unknown, focal), CameraOf(focal));
  };
  double best = 0.0, least = mismatch(0.0);
  for (double step = 0.2, reach = std::log(kGreatestFocal), centre = 0.0; step > 1e-3; step *= 0.1, centre = best) {
    for (double at = centre - reach; at <= centre + reach; at += step) {
      const double value = mismatch(at);
      if (!(value < least)) continue;
      least = value;
      best = at;
    }
    reach = step;
  }
  return std::exp(best);
}

}  // namespace

template <UnknownFocal kUnknown>
int FocalModel<kUnknown>::SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
  if (points.cols() != 4) return 0;
  double p[kMinimalSize][4];
  for (int i = 0; i < kMinimalSize; ++i)
    for (int j = 0; j < 4; ++j) p[i][j] = points(set[i], j);
  Parameters found[MaxSixPointSolutions(kUnknown)];
  const int solutions = SolveSixPoints<kUnknown>(p, found);
  int count = 0;
  for (int i = 0; i < solutions; ++i)
    if (IsPossible(kUnknown, found[i], p, kMinimalSize)) out[count++] = found[i];
  for (const double focal : kAssumed) {
    double calibrated[Essential::kMinimalSize][4];
    CalibratedPoints(kUnknown, focal, p, Essential::kMinimalSize, calibrated);
    Matrix3Parameters essential[Essential::kMaxSolutions];
    const int of_five = SolveFivePoints(calibrated, true, essential);
    for (int i = 0; i < of_five; ++i) out[count++] = AsFocalParameters(essential[i], focal);
  }
  return count;
}

template <UnknownFocal kUnknown>
bool FocalModel<kUnknown>::Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
  Matrix3Parameters f;
  if (!Fundamental::Fit(points, weights, &f)) return false;
  const double focal = FocalOf(kUnknown, f);
  const Eigen::Matrix3d e = EssentialFromFundamental(AsMatrix(f), FirstCamera(kUnknown, focal), CameraOf(focal));
  Parameters model = AsFocalParameters(AsParameters(ClosestEssential(e)), focal);
  if (!FitFrom(points, weights, &model)) return false;
  *out = model;
  return true;
}

template <UnknownFocal kUnknown>
bool FocalModel<kUnknown>::FitFrom(const PointMatrix& points, const Eigen::VectorXd& weights, const FocalPrior& prior,
                                   Parameters* model) {
  RefineOptions options;
  options.loss = {LossKind::kTrivial};
  options.relative_tolerance = 1e-6;
  return RefineFocal(kUnknown, points, weights, options, prior, model).status == Status::kOk;
}

template <UnknownFocal kUnknown>
bool FocalModel<kUnknown>::Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                                  const FocalPrior& prior, Parameters* model, int steps) {
  if (points.cols() != 4 || weights.size() != points.rows() || !(loss.scale > 0.0) || !std::isfinite(loss.scale) ||
      !model->allFinite())
    return false;
  const Matrix3Parameters f = FundamentalOf(kUnknown, *model);
  Eigen::VectorXd near = weights;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (!(SampsonError(f, points.row(i).data()) <= kRefineReach * loss.scale)) near[i] = 0.0;
  RefineOptions options;
  options.loss = loss;
  options.max_iterations = steps;
  const Parameters before = *model;
  return RefineFocal(kUnknown, points, near, options, prior, model).status == Status::kOk && *model != before;
}

template <UnknownFocal kUnknown>
double FocalModel<kUnknown>::CameraMismatch(const Parameters& model, const Eigen::Matrix3d&,
                                            const Eigen::Matrix3d& K2) {
  const double deviation = std::log(model[9] / K2(0, 0));
  return deviation * deviation;
}

template struct FocalModel<UnknownFocal::kBoth>;
template struct FocalModel<UnknownFocal::kSecond>;

}  // namespace diffsac
