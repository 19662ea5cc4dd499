#include "diffsac/geometry/shared_focal.h"

#include <Eigen/Geometry>
#include <cmath>

#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/refine.h"

namespace diffsac {
namespace {

Eigen::Matrix3d CameraOf(double focal) { return Eigen::DiagonalMatrix<double, 3>(focal, focal, 1.0); }

Eigen::Matrix3d FirstCamera(UnknownFocal unknown, double focal) {
  return CameraOf(unknown == UnknownFocal::kSecond ? 1.0 : focal);
}

/// Whether all points can lie before both cameras.
bool IsPossible(const FocalParameters& model, const double (*points)[4], int count) {
  double calibrated[7][4];
  for (int i = 0; i < count; ++i) DivideByFocals(model[9], model[10], points[i], calibrated[i]);
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

/// The square of the first image's length, of rows and columns about the principal points.
double SquareOfFirst(const Eigen::Matrix3d& f) {
  // The epipole of the second image: what all columns are orthogonal to, by the largest product of two.
  Eigen::Vector3d epipole = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d product = f.col(i).cross(f.col((i + 1) % 3));
    if (product.squaredNorm() > epipole.squaredNorm()) epipole = product;
  }
  const Eigen::RowVector2d across(-epipole[1], epipole[0]);
  const double above = across.dot(f.col(2).head<2>().transpose()) * f(2, 2);
  const double below = across * f.topLeftCorner<2, 2>() * f.bottomLeftCorner<1, 2>().transpose();
  return -above / below;
}

/// E of an F with these focal lengths.
FocalParameters ModelOf(const Matrix3Parameters& f, double focal1, double focal2) {
  const Eigen::Matrix3d e = EssentialFromFundamental(AsMatrix(f), CameraOf(focal1), CameraOf(focal2));
  return AsFocalParameters(AsParameters(ClosestEssential(e)), focal1, focal2);
}

int SolveSevenPointsWithFocals(const PointMatrix& points, const int* set, FocalParameters* out) {
  Matrix3Parameters f[Fundamental::kMaxSolutions];
  const int count = Fundamental::SolveMinimal(points, set, f);
  for (int i = 0; i < count; ++i) {
    double focal1 = 1.0, focal2 = 1.0;
    FocalsOfFundamental(f[i], &focal1, &focal2);
    out[i] = ModelOf(f[i], focal1, focal2);
  }
  return count;
}

}  // namespace

bool FocalsOfFundamental(const Matrix3Parameters& fundamental, double* focal1, double* focal2) {
  const Eigen::Matrix3d f = AsMatrix(fundamental);
  const double first = SquareOfFirst(f), second = SquareOfFirst(f.transpose());
  constexpr double kGreatest = kGreatestFocal * kGreatestFocal;
  for (const double square : {first, second})
    if (!(square * kGreatest > 1.0 && square < kGreatest)) return false;
  *focal1 = std::sqrt(first);
  *focal2 = std::sqrt(second);
  return true;
}

template <UnknownFocal kUnknown>
int FocalModel<kUnknown>::SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
  if (points.cols() != 4) return 0;
  double p[kMinimalSize][4];
  for (int i = 0; i < kMinimalSize; ++i)
    for (int j = 0; j < 4; ++j) p[i][j] = points(set[i], j);
  Parameters found[kOfAllPoints];
  int solutions = 0, count = 0;
  if constexpr (kUnknown == UnknownFocal::kEach)
    solutions = SolveSevenPointsWithFocals(points, set, found);
  else
    solutions = SolveSixPoints<kUnknown>(p, found);
  for (int i = 0; i < solutions; ++i)
    if (IsPossible(found[i], p, kMinimalSize)) out[count++] = found[i];
  for (const double focal : kAssumed) {
    double calibrated[Essential::kMinimalSize][4];
    const FocalParameters assumed = AsFocalParameters(kUnknown, Matrix3Parameters::Ones(), focal);
    for (int i = 0; i < Essential::kMinimalSize; ++i) DivideByFocals(assumed[9], assumed[10], p[i], calibrated[i]);
    Matrix3Parameters essential[Essential::kMaxSolutions];
    const int of_five = SolveFivePoints(calibrated, true, essential);
    for (int i = 0; i < of_five; ++i) out[count++] = AsFocalParameters(kUnknown, essential[i], focal);
  }
  return count;
}

template <UnknownFocal kUnknown>
bool FocalModel<kUnknown>::Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
  Matrix3Parameters f;
  if (!Fundamental::Fit(points, weights, &f)) return false;
  double focal1 = 1.0, focal2 = 1.0;
  if constexpr (kUnknown == UnknownFocal::kEach) {
    FocalsOfFundamental(f, &focal1, &focal2);
  } else {
    focal2 = FocalOf(kUnknown, f);
    if (kUnknown == UnknownFocal::kBoth) focal1 = focal2;
  }
  Parameters model = ModelOf(f, focal1, focal2);
  if (!FitFrom(points, weights, &model)) return false;
  *out = model;
  return true;
}

template <UnknownFocal kUnknown>
bool FocalModel<kUnknown>::FitFrom(const PointMatrix& points, const Eigen::VectorXd& weights, const FocalPriors& priors,
                                   Parameters* model) {
  RefineOptions options;
  options.loss = {LossKind::kTrivial};
  options.relative_tolerance = 1e-6;
  return RefineFocal(kUnknown, points, weights, options, priors, model).status == Status::kOk;
}

template <UnknownFocal kUnknown>
bool FocalModel<kUnknown>::Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                                  const FocalPriors& priors, Parameters* model, int steps) {
  if (points.cols() != 4 || weights.size() != points.rows() || !(loss.scale > 0.0) || !std::isfinite(loss.scale) ||
      !model->allFinite())
    return false;
  const Matrix3Parameters f = FundamentalOf(*model);
  Eigen::VectorXd near = weights;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (!(SampsonError(f, points.row(i).data()) <= kRefineReach * loss.scale)) near[i] = 0.0;
  RefineOptions options;
  options.loss = loss;
  options.max_iterations = steps;
  const Parameters before = *model;
  return RefineFocal(kUnknown, points, near, options, priors, model).status == Status::kOk && *model != before;
}

template <UnknownFocal kUnknown>
double FocalModel<kUnknown>::CameraMismatch(const Parameters& model, const Eigen::Matrix3d& K1,
                                            const Eigen::Matrix3d& K2) {
  const double deviation = std::log(model[10] / K2(0, 0));
  if constexpr (kUnknown != UnknownFocal::kEach) return deviation * deviation;
  const double of_first = std::log(model[9] / K1(0, 0));
  return of_first * of_first + deviation * deviation;
}

template struct FocalModel<UnknownFocal::kBoth>;
template struct FocalModel<UnknownFocal::kSecond>;
template struct FocalModel<UnknownFocal::kEach>;

}  // namespace diffsac
