#include "diffsac/geometry/covariance.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/rotation.h"
#include "diffsac/geometry/sampson_equations.h"

namespace diffsac {
namespace {

/// What is farther away, in σ, is hardly Gaussian noise.
constexpr double kTailSigmas = 3.0;
/// A σ so small a share of the threshold is below all that were looked for: half of what has 2.5 σ within it.
constexpr double kFarBelow = 0.2;

/// The length of Gaussian residuals of `dimension` values (1 to 3) and σ = 1 that is cut off at `threshold`.
struct CutLength {
  double share = 0.0;   ///< Of residuals within the threshold.
  double square = 0.0;  ///< The mean square of these, by dimension; 1 without a threshold.

  CutLength(int dimension, double threshold) {
    const double half = 0.5 * threshold * threshold, density = std::exp(-half);
    constexpr double kSqrtTwoOverPi = 0.79788456080286535588;
    if (dimension == 1) {
      share = std::erf(std::sqrt(half));
      square = 1.0 - kSqrtTwoOverPi * threshold * density / share;
    } else if (dimension == 3) {
      share = std::erf(std::sqrt(half)) - kSqrtTwoOverPi * threshold * density;
      square = 1.0 - kSqrtTwoOverPi * threshold * threshold * threshold * density / (3.0 * share);
    } else {
      share = -std::expm1(-half);
      square = 1.0 - half * density / share;
    }
  }
};

/// The threshold, in σ, within which Gaussian residuals have this mean square by dimension, in squares of the
/// threshold. 0 without noise, and where it is below 1: the inliers then hardly tell a Gaussian from any other noise.
double ThresholdInSigmas(int dimension, double mean_square) {
  const auto is_below = [&](double a) { return CutLength(dimension, a).square > mean_square * a * a; };
  double low = 1.0, high = 1.0 / std::sqrt(mean_square);
  if (!std::isfinite(high) || !is_below(low)) return 0.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (is_below(middle) ? low : high) = middle;
  }
  return low;
}

/// ThresholdInSigmas of the residuals within the threshold, `free` of their values being the model's; 0 where they are
/// no more than these.
double SigmasWithin(const Eigen::VectorXd& residuals, int dimension, Eigen::Index free, double threshold) {
  const auto inlier = residuals.array() <= threshold;
  const double spare = dimension * static_cast<double>(inlier.count()) - static_cast<double>(free);
  if (!(spare > 0.0)) return 0.0;
  const Eigen::ArrayXd shares = inlier.select(residuals.array() / threshold, 0.0);
  return ThresholdInSigmas(dimension, shares.square().sum() / spare);
}

/// What a loss makes of Gaussian residuals of σ, w being its weight of a residual of length r.
struct LossFactors {
  double variance;  ///< Of the M-estimate in that of least squares by the same points: d E[w² r²] / E[w r²]².
  double slope;     ///< Of the residuals' pull w r in that of least squares: E[w r²] / d σ².
};

LossFactors FactorsOf(const RobustLoss& loss, int dimension, double sigma) {
  constexpr int kSteps = 512;
  constexpr double kReach = 8.0;
  double density = 0.0, first = 0.0, second = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double r = kReach * (i + 0.5) / kSteps, square = r * r;
    const double p = std::exp(-0.5 * square) * std::pow(r, dimension - 1);
    const double weight = loss.Weight(square * sigma * sigma);
    density += p;
    first += p * weight * square;
    second += p * weight * weight * square;
  }
  return {dimension * density * second / (first * first), first / (dimension * density)};
}

/// A⁻¹ B A⁻¹; nothing where A leaves a direction open. Parameters may be of any units.
std::optional<Eigen::MatrixXd> Sandwich(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  constexpr double kLeast = 1e-11;
  if (!a.allFinite() || !b.allFinite() || !(a.diagonal().minCoeff() > 0.0)) return std::nullopt;
  const Eigen::VectorXd unit = a.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(unit.asDiagonal() * a * unit.asDiagonal());
  if (!(solver.eigenvalues()[0] > kLeast)) return std::nullopt;
  const Eigen::MatrixXd inverse = unit.asDiagonal() * solver.eigenvectors() *
                                  solver.eigenvalues().cwiseInverse().asDiagonal() * solver.eigenvectors().transpose() *
                                  unit.asDiagonal();
  const Eigen::MatrixXd covariance = inverse * b * inverse;
  if (!covariance.allFinite()) return std::nullopt;
  return 0.5 * (covariance + covariance.transpose());
}

/// Of directions that leave the length of t as it is, (ω, t) of each.
Eigen::Matrix<double, 6, 5> PosesOfUnitLength(const Eigen::Vector3d& t) {
  Eigen::Matrix<double, 6, 5> basis = Eigen::Matrix<double, 6, 5>::Zero();
  basis.topLeftCorner<3, 3>().setIdentity();
  basis.bottomRightCorner<3, 2>() = PlaneBasis(t);
  return basis;
}

/// Σ w JᵀJ that noise of σ = 1 adds on average, J being the derivatives of Sampson distances: what moves a point along
/// its epipolar line looks like parallax. Without it matches of little parallax would seem to say of t what they do
/// not.
Eigen::MatrixXd InformationOfNoise(const PointMatrix& points, const Matrix3Parameters& f,
                                   const Eigen::MatrixXd& derivative, const Eigen::VectorXd& weights,
                                   double threshold) {
  // A point this near to the epipoles, where the first order of the noise says nothing, is left out.
  constexpr double kNear = 4.0;
  const Eigen::Matrix3d model = AsMatrix(f);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(derivative.cols(), derivative.cols());
  const double least = std::pow(kNear * threshold, 2) * model.topLeftCorner<2, 2>().squaredNorm();
  Eigen::Matrix<double, 4, 9> by_entry;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (!(weights[i] > 0.0)) continue;
    const Eigen::Vector3d x1(points(i, 0), points(i, 1), 1.0), x2(points(i, 2), points(i, 3), 1.0);
    Eigen::Vector4d gradient;
    gradient << (model.transpose() * x2).head<2>(), (model * x1).head<2>();
    const double square = gradient.squaredNorm();
    if (!(square > least)) continue;
    // Of x2ᵀ F x1, by coordinate and entry of F.
    by_entry.setZero();
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        if (c < 2) by_entry(c, 3 * r + c) = x2[r];
        if (r < 2) by_entry(2 + r, 3 * r + c) = x1[c];
      }
    const Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, 7> by_parameter = by_entry * derivative;
    const Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, 7> across = gradient.transpose() * by_parameter;
    sum += weights[i] / square * (by_parameter.transpose() * by_parameter - across.transpose() * across / square);
  }
  return sum;
}

/// Of a matrix with x2ᵀ F x1 = 0, of any length, by the parameters that its derivative is by.
std::optional<Eigen::MatrixXd> EpipolarCovariance(const PointMatrix& points, const Matrix3Parameters& f,
                                                  const Eigen::MatrixXd& derivative, const FitConditions& fit) {
  const int count = static_cast<int>(points.rows());
  const Eigen::Matrix<double, Eigen::Dynamic, 4> columns = points;
  const double* pointers[4] = {columns.col(0).data(), columns.col(1).data(), columns.col(2).data(),
                               columns.col(3).data()};
  Eigen::VectorXd residuals(count);
  SampsonDistances(f.data(), pointers, 0, count, residuals.data());
  const auto information = [&](const Eigen::VectorXd& weights) {
    const NormalEquations equations = SumSampsonEquations(f.data(), pointers, weights.data(), count);
    return Eigen::MatrixXd(derivative.transpose() * equations.normal * derivative);
  };
  const auto noise = [&](const Eigen::VectorXd& weights) {
    return InformationOfNoise(points, f, derivative, weights, fit.threshold);
  };
  return CovarianceOfFit(residuals, 1, fit, information, noise);
}

}  // namespace

std::optional<Eigen::MatrixXd> CovarianceOfFit(const Eigen::VectorXd& residuals, int residual_dimension,
                                               const FitConditions& fit, const InformationFunction& information,
                                               const InformationFunction& noise) {
  const double threshold = fit.threshold;
  if (!(threshold > 0.0) || !std::isfinite(threshold)) return std::nullopt;
  const Eigen::ArrayXd inlier = (residuals.array() <= threshold).cast<double>();
  const bool weighted = fit.weights.size() > 0;
  const Eigen::VectorXd weights = weighted ? Eigen::VectorXd(inlier * fit.weights.array()) : inlier.matrix();
  const Eigen::MatrixXd a = information(weights);
  double sigma = NoiseOfInliers(residuals, residual_dimension, static_cast<int>(a.rows()), threshold);
  // Noise far below all scales that the fit knew: of the inliers, and of others that the loss listens to, some are
  // none.
  const bool tails = sigma < kFarBelow * threshold;
  if (!tails) {
    const double sigmas = SigmasWithin(residuals, residual_dimension, a.rows(), threshold);
    if (!(sigmas > 0.0)) return std::nullopt;
    sigma = threshold / sigmas;
  }
  if (!(sigma > 0.0)) return std::nullopt;
  const LossFactors factors = FactorsOf(fit.loss, residual_dimension, sigma);
  const double factor = CutLength(residual_dimension, threshold / sigma).share * factors.variance;
  const double variance = factor * sigma * sigma;
  Eigen::MatrixXd b = weighted ? information(weights.cwiseProduct(fit.weights)) : a;
  if (tails) {
    const double unit = residual_dimension * variance * factors.slope * factors.slope;
    Eigen::VectorXd pulls = residuals.unaryExpr([&](double r) {
      return r > kTailSigmas * sigma && std::isfinite(r) ? std::pow(r * fit.loss.Weight(r * r), 2) / unit : 0.0;
    });
    if (weighted) pulls.array() *= fit.weights.array().square();
    b += information(pulls);
  }
  auto covariance = Sandwich(noise ? Eigen::MatrixXd(a - sigma * sigma * noise(weights)) : a, b);
  if (covariance) *covariance *= variance;
  return covariance && covariance->allFinite() ? covariance : std::nullopt;
}

double NoiseOfInliers(const Eigen::VectorXd& residuals, int dimension, int free, double threshold) {
  constexpr double kSigmas = 2.5, kSettled = 0.99;
  const auto within = [&](double length) { return static_cast<int>((residuals.array() <= length).count()); };
  const int inliers = within(threshold);
  if (!(dimension * inliers > free)) return std::numeric_limits<double>::quiet_NaN();
  if ((residuals.array() <= threshold).select(residuals.array(), 0.0).maxCoeff() == 0.0) return 0.0;
  double reach = threshold, sigma = threshold;
  for (;;) {
    const double sigmas = SigmasWithin(residuals, dimension, free, reach);
    if (!(sigmas > 0.0)) return sigma;
    sigma = reach / sigmas;
    const double next = kSigmas * sigma;
    // Of residuals of two kinds the larger half is not thrown away.
    if (!(next < kSettled * reach) || 2 * within(next) < inliers) return sigma;
    reach = next;
  }
}

Eigen::Matrix<double, 9, 6> EssentialByPose(const RelativePose& pose) {
  Eigen::Matrix<double, 9, 6> derivative;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Matrix3d turn = CrossMatrix(Eigen::Vector3d::Unit(i));
    derivative.col(i) = Flatten(CrossMatrix(pose.translation) * turn * pose.rotation);
    derivative.col(3 + i) = Flatten(turn * pose.rotation);
  }
  return derivative;
}

std::optional<Eigen::MatrixXd> RelativePoseCovariance(const PointMatrix& points, const RelativePose& pose,
                                                      const FitConditions& fit) {
  const Eigen::Matrix<double, 6, 5> basis = PosesOfUnitLength(pose.translation);
  const auto covariance =
      EpipolarCovariance(points, Flatten(EssentialFromPose(pose)), EssentialByPose(pose) * basis, fit);
  if (!covariance) return std::nullopt;
  return basis * *covariance * basis.transpose();
}

std::optional<Eigen::MatrixXd> AbsolutePoseCovariance(const PointMatrix& points, const AbsolutePose::Parameters& pose,
                                                      const FitConditions& fit) {
  const Eigen::VectorXd residuals = RowResiduals<AbsolutePose>(points, pose);
  return CovarianceOfFit(residuals, AbsolutePose::kResidualDimension, fit, [&](const Eigen::VectorXd& weights) {
    return Eigen::MatrixXd(ReprojectionInformation(points, weights, pose));
  });
}

}  // namespace diffsac
