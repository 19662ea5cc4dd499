#include "diffsac/geometry/photographs.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/levenberg_marquardt.h"
#include "diffsac/geometry/manifolds.h"
#include "diffsac/geometry/robust_loss_sums.h"
#include "diffsac/geometry/rotation.h"
#include "diffsac/geometry/sampson_equations.h"

namespace diffsac {
namespace {

/// Scales of Student's t of one degree of freedom: of principal points, in focal lengths of the prior, and of the
/// logarithm of a ratio of focal lengths. Chosen on the tuning scenes (docs/two_view.md).
constexpr double kPointScale = 0.03, kRatioScale = 0.01, kTails = 1.0;

/// f K⁻¹ of an image.
Eigen::Matrix3d InverseCamera(double focal, const Eigen::Vector2d& principal_point) {
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Identity();
  inverse.col(2) << -principal_point, focal;
  return inverse;
}

/// E, then log f of both images, then their principal points.
struct Cameras {
  EssentialManifold essential;
  Eigen::Vector2d log_focals;
  Eigen::Vector4d principal_points;

  static Cameras Of(const PhotographPair& pair) {
    return {EssentialManifold::From(pair.model.head<9>()), pair.model.tail<2>().array().log(), pair.principal_points};
  }
  PhotographPair Pair() const {
    return {AsFocalParameters(essential.Parameters(), std::exp(log_focals[0]), std::exp(log_focals[1])),
            principal_points};
  }
  Eigen::Matrix<double, 6, 1> Unknowns() const {
    Eigen::Matrix<double, 6, 1> unknowns;
    unknowns << log_focals, principal_points;
    return unknowns;
  }
  Eigen::Matrix3d First() const { return InverseCamera(std::exp(log_focals[0]), principal_points.head<2>()); }
  Eigen::Matrix3d Second() const { return InverseCamera(std::exp(log_focals[1]), principal_points.tail<2>()); }
  Matrix3Parameters Fundamental() const {
    return Flatten(Second().transpose() * AsMatrix(essential.Parameters()) * First());
  }
  /// Of Fundamental() by the eleven.
  Eigen::Matrix<double, 9, 11> Tangent() const {
    const Eigen::Matrix3d first = First(), second = Second(), e = AsMatrix(essential.Parameters());
    const Eigen::Matrix3d left = second.transpose() * e, right = e * first;
    const Eigen::Matrix<double, 9, 5> of_essential = essential.Tangent();
    Eigen::Matrix<double, 9, 11> tangent;
    for (int i = 0; i < 5; ++i) tangent.col(i) = Flatten(second.transpose() * AsMatrix(of_essential.col(i)) * first);
    // The last column of f K⁻¹ is −c, f.
    for (int k = 0; k < 3; ++k) {
      Eigen::Matrix3d of_first = Eigen::Matrix3d::Zero(), of_second = Eigen::Matrix3d::Zero();
      of_first.col(2) = (k == 2 ? first(2, 2) : -1.0) * left.col(k);
      of_second.row(2) = (k == 2 ? second(2, 2) : -1.0) * right.row(k);
      tangent.col(k == 2 ? 5 : 7 + k) = Flatten(of_first);
      tangent.col(k == 2 ? 6 : 9 + k) = Flatten(of_second);
    }
    return tangent;
  }
};

/// Of log f of both images and their principal points, z: Gaussian, or Student's t, of the length of A z − b.
struct PriorTerm {
  Eigen::Matrix<double, 2, 6> a = Eigen::Matrix<double, 2, 6>::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  int dimensions = 1;
  bool heavy = true;

  /// −2 log of its density, less a constant.
  double Value(double square) const { return heavy ? (kTails + dimensions) * std::log1p(square / kTails) : square; }
  /// Its derivative by the square.
  double Weight(double square) const { return heavy ? (kTails + dimensions) / (kTails + square) : 1.0; }
};

std::vector<PriorTerm> TermsOf(const PhotographPriors& priors) {
  std::vector<PriorTerm> terms;
  for (int k = 0; k < 2; ++k) {
    const FocalPrior& prior = priors.focals[k];
    PriorTerm& length = terms.emplace_back();
    length.a(0, k) = 1.0 / prior.log_sigma;
    length.b[0] = std::log(prior.focal) / prior.log_sigma;
    length.heavy = false;
    PriorTerm& point = terms.emplace_back();
    point.a.block<2, 2>(0, 2 + 2 * k) = Eigen::Matrix2d::Identity() / (kPointScale * prior.focal);
    point.dimensions = 2;
  }
  if (!priors.one_size) return terms;
  PriorTerm& ratio = terms.emplace_back();
  ratio.a(0, 0) = 1.0 / kRatioScale;
  ratio.a(0, 1) = -1.0 / kRatioScale;
  return terms;
}

struct CameraProblem {
  static constexpr int kFreedom = 11;
  using Vector = Eigen::Matrix<double, kFreedom, 1>;
  using Matrix = Eigen::Matrix<double, kFreedom, kFreedom>;

  const NearMatches& matches;
  const std::vector<PriorTerm> terms;
  Eigen::VectorXd distances, pulls;

  double Cost(const Cameras& state) {
    double penalty = 0.0;
    for (const PriorTerm& term : terms) penalty += term.Value((term.a * state.Unknowns() - term.b).squaredNorm());
    SampsonDistances(state.Fundamental().data(), matches.Columns().data(), 0, matches.Count(), distances.data());
    return SumLoss(matches.loss, distances.data(), matches.weights.data(), matches.Count()) +
           matches.variance * penalty;
  }

  void Linearize(const Cameras& state, Matrix* normal, Vector* gradient) {
    LossWeights(matches.loss, distances.data(), matches.weights.data(), matches.Count(), pulls.data());
    const NormalEquations of_points =
        SumSampsonEquations(state.Fundamental().data(), matches.Columns().data(), pulls.data(), matches.Count());
    const Eigen::Matrix<double, 9, kFreedom> tangent = state.Tangent();
    *normal = tangent.transpose() * of_points.normal * tangent;
    *gradient = tangent.transpose() * of_points.gradient;
    for (const PriorTerm& term : terms) {
      const Eigen::Vector2d offset = term.a * state.Unknowns() - term.b;
      const double weight = matches.variance * term.Weight(offset.squaredNorm());
      normal->bottomRightCorner<6, 6>() += weight * term.a.transpose() * term.a;
      gradient->tail<6>() += weight * term.a.transpose() * offset;
    }
  }
  static Vector Solve(const Matrix& damped, const Vector& right) { return damped.llt().solve(right); }
  static Cameras Retract(const Cameras& state, const Vector& step) {
    return {state.essential.Retract(step.head<5>()), state.log_focals + step.segment<2>(5),
            state.principal_points + step.tail<4>()};
  }
};

}  // namespace

Matrix3Parameters FundamentalOf(const PhotographPair& pair) { return Cameras::Of(pair).Fundamental(); }

double RefinePhotographs(const NearMatches& matches, const PhotographPriors& priors, PhotographPair* pair) {
  Cameras state = Cameras::Of(*pair);
  // Points that are near the right F may be out of the loss's reach at the start.
  NearMatches far_reaching = matches;
  far_reaching.loss = {LossKind::kHuber, std::max(matches.loss.least, 0.25 * matches.loss.scale)};
  const Eigen::VectorXd room(matches.Count());
  const LevenbergOptions options{kMostRefineSteps, 1e-6, 1e-12, 1e-10, true};
  for (const NearMatches* given : {static_cast<const NearMatches*>(&far_reaching), &matches}) {
    CameraProblem problem{*given, TermsOf(priors), room, room};
    const LevenbergResult result = Minimize(problem, options, &state);
    if (given == &matches && std::isfinite(result.last_cost)) {
      *pair = state.Pair();
      return result.last_cost;
    }
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace diffsac
