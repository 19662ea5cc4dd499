#include "diffsac/geometry/refine.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/homography_sampson.h"
#include "diffsac/geometry/levenberg_marquardt.h"
#include "diffsac/geometry/manifolds.h"
#include "diffsac/geometry/robust_loss_sums.h"
#include "diffsac/geometry/sampson_equations.h"
#include "diffsac/geometry/weighted_pairs.h"

namespace diffsac {
namespace {

/// Sampson distances: one residual a point.
struct SampsonResiduals {
  static void Distances(const Matrix3Parameters& model, const double* const* columns, int count, double* out) {
    SampsonDistances(model.data(), columns, 0, count, out);
  }
  static NormalEquations Equations(const Matrix3Parameters& model, const double* const* columns, const double* weights,
                                   int count) {
    return SumSampsonEquations(model.data(), columns, weights, count);
  }
};

/// First-order distances from a homography.
struct HomographySampsonResiduals {
  static void Distances(const Matrix3Parameters& model, const double* const* columns, int count, double* out) {
    HomographySampsonDistances(model.data(), columns, 0, count, out);
  }
  static NormalEquations Equations(const Matrix3Parameters& model, const double* const* columns, const double* weights,
                                   int count) {
    return SumHomographySampsonEquations(model.data(), columns, weights, count);
  }
};

/// The robust cost of a model and its normal equations; several points are handled at a time. Borrows pairs.
template <class Residuals>
class RobustCost {
 public:
  RobustCost(const WeightedPairs& pairs, const RobustLoss& loss)
      : loss_(loss), size_(pairs.positive()), weights_(pairs.column(4)), distances_(size_), work_(size_) {
    for (int j = 0; j < 4; ++j) columns_[j] = pairs.column(j);
  }

  double operator()(const Matrix3Parameters& model) {
    Evaluate(model);
    return SumLoss(loss_, distances_.data(), weights_, size_);
  }

  /// Of all pairs.
  const Eigen::VectorXd& Distances(const Matrix3Parameters& model) {
    Evaluate(model);
    return distances_;
  }

  NormalEquations Linearize(const Matrix3Parameters& model) {
    Evaluate(model);
    LossWeights(loss_, distances_.data(), weights_, size_, work_.data());
    return Residuals::Equations(model, columns_, work_.data(), size_);
  }

 private:
  /// A model is mostly linearised right after its cost was asked for.
  void Evaluate(const Matrix3Parameters& model) {
    if (model == evaluated_) return;
    Residuals::Distances(model, columns_, size_, distances_.data());
    evaluated_ = model;
  }

  RobustLoss loss_;
  int size_;
  const double* weights_;
  const double* columns_[4];
  Eigen::VectorXd distances_, work_;
  Matrix3Parameters evaluated_ = Matrix3Parameters::Zero();  ///< What distances_ are of; 0: nothing.
};

/// Manifolds of which some points are likelier.
template <class Manifold>
concept HasPenalty = requires(const Manifold& state) {
  state.Penalty();
};

/// The cost of a model on its manifold.
template <class Manifold, class Residuals>
struct ManifoldProblem {
  static constexpr int kFreedom = Manifold::kFreedom;
  using Vector = Eigen::Matrix<double, kFreedom, 1>;
  using Matrix = Eigen::Matrix<double, kFreedom, kFreedom>;
  RobustCost<Residuals> of_points;

  double Cost(const Manifold& state) {
    const double cost = of_points(state.Parameters());
    if constexpr (HasPenalty<Manifold>) return cost + state.Penalty();
    return cost;
  }
  void Linearize(const Manifold& state, Matrix* normal, Vector* gradient) {
    const Eigen::Matrix<double, 9, kFreedom> tangent = state.Tangent();
    const NormalEquations equations = of_points.Linearize(state.Parameters());
    *normal = tangent.transpose() * equations.normal * tangent;
    *gradient = tangent.transpose() * equations.gradient;
    if constexpr (HasPenalty<Manifold>) state.AddPenalty(normal, gradient);
  }
  static Vector Solve(const Matrix& damped, const Vector& right) { return damped.llt().solve(right); }
  static Manifold Retract(const Manifold& state, const Vector& step) { return state.Retract(step); }
};

/// True when the model moved.
template <class Residuals, class Manifold>
bool MinimizeOn(const RobustCost<Residuals>& cost, const RefineOptions& options, Manifold* state,
                RefineReport* report) {
  ManifoldProblem<Manifold, Residuals> problem{cost};
  const LevenbergResult result =
      Minimize(problem, {options.max_iterations, options.relative_tolerance, 1e-12, 1e-10, true}, state);
  report->iterations = result.steps;
  report->initial_cost = result.first_cost;
  report->final_cost = result.last_cost;
  return result.moved;
}

/// Checks, normalises with one scale for both images (so that distances in both keep their proportion) and collects.
Status Prepare(const PointMatrix& points, const Eigen::VectorXd& weights, int min_points, bool normalize,
               const Matrix3Parameters& model, PairNormalization* normalization, WeightedPairs* pairs) {
  if (points.cols() != 4 || !model.allFinite() || !(model.norm() > 0.0)) return Status::kDegenerate;
  if (!pairs->Collect(points, weights)) return Status::kDegenerate;
  if (pairs->positive() < min_points) return Status::kTooFewPoints;
  *normalization = {};
  if (normalize) {
    if (!pairs->Normalize()) return Status::kDegenerate;
    *normalization = pairs->normalization();
    normalization->first.scale = normalization->second.scale =
        std::sqrt(normalization->first.scale * normalization->second.scale);
    pairs->Scale(normalization->first.scale);
  }
  return pairs->columns().allFinite() ? Status::kOk : Status::kDegenerate;
}

/// Brings the costs back from normalised units.
void Rescale(double scale, RefineReport* report) {
  report->initial_cost /= scale * scale;
  report->final_cost /= scale * scale;
}

RobustLoss Scaled(const RobustLoss& loss, double scale) { return {loss.kind, loss.scale * scale, loss.least * scale}; }

/// Sets *model when the refined one is finite; else reports no change.
template <class Parameters>
void Keep(const Parameters& refined, RefineReport* report, Parameters* model) {
  if (refined.allFinite()) {
    *model = refined;
  } else {
    report->final_cost = report->initial_cost;
  }
}

/// ψ' of a residual's distance, numerically.
double SlopeOfPull(const RobustLoss& loss, double distance) {
  const double step = 1e-4 * loss.scale;
  const auto pull = [&](double r) { return r * loss.Weight(r * r); };
  return (pull(distance + step) - pull(distance - step)) / (2.0 * step);
}

template <UnknownFocal kUnknown, bool kHeld>
RefineReport RefineOnFocalManifold(const PointMatrix& points, const Eigen::VectorXd& weights,
                                   const RefineOptions& options, const FocalPriors& priors, FocalParameters* model) {
  using Manifold = FocalManifold<kUnknown, kHeld>;
  RefineReport report;
  PairNormalization identity;
  WeightedPairs pairs;
  report.status = Prepare(points, weights, Manifold::kFreedom, false, model->head<9>(), &identity, &pairs);
  if (!((*model)[9] > 0.0) || !((*model)[10] > 0.0)) report.status = Status::kDegenerate;
  if (report.status != Status::kOk) return report;
  Manifold state = Manifold::From(*model);
  RobustCost<SampsonResiduals> cost(pairs, options.loss);
  if (!kHeld && (priors[0].log_sigma > 0.0 || priors[1].log_sigma > 0.0)) {
    const Eigen::VectorXd distances = cost.Distances(state.Parameters());
    const double variance =
        ResidualVariance(options.loss, distances.data(), pairs.column(4), pairs.positive(), Manifold::kFreedom);
    for (int k = 2 - Manifold::kFocals; k < 2; ++k) {
      if (!(priors[k].log_sigma > 0.0)) continue;
      state.prior_weight[k] = variance / (priors[k].log_sigma * priors[k].log_sigma);
      state.log_median[k] = std::log(priors[k].focal);
    }
  }
  const double penalty = state.Penalty();
  const bool moved = MinimizeOn(cost, options, &state, &report);
  report.initial_cost -= penalty;
  report.final_cost -= state.Penalty();
  if (moved) Keep(state.Model(), &report, model);
  return report;
}

template <bool kHeld>
RefineReport RefineOnFocalManifold(UnknownFocal unknown, const PointMatrix& points, const Eigen::VectorXd& weights,
                                   const RefineOptions& options, const FocalPriors& priors, FocalParameters* model) {
  switch (unknown) {
    case UnknownFocal::kBoth:
      return RefineOnFocalManifold<UnknownFocal::kBoth, kHeld>(points, weights, options, priors, model);
    case UnknownFocal::kSecond:
      return RefineOnFocalManifold<UnknownFocal::kSecond, kHeld>(points, weights, options, priors, model);
    case UnknownFocal::kEach:
      break;
  }
  return RefineOnFocalManifold<UnknownFocal::kEach, kHeld>(points, weights, options, priors, model);
}

/// Refines in normalised coordinates: `to` takes a model there, `back` takes it from there.
template <class Manifold, class Residuals, class To, class Back>
RefineReport RefineNormalized(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                              int fewest, const To& to, const Back& back, Matrix3Parameters* model) {
  RefineReport report;
  PairNormalization n;
  WeightedPairs pairs;
  report.status = Prepare(points, weights, fewest, true, *model, &n, &pairs);
  if (report.status != Status::kOk) return report;
  const double scale = n.first.scale;
  Manifold state = Manifold::From(AsParameters(to(n, AsMatrix(*model))));
  const bool moved = MinimizeOn(RobustCost<Residuals>(pairs, Scaled(options.loss, scale)), options, &state, &report);
  Rescale(scale, &report);
  if (moved) Keep(AsParameters(back(n, AsMatrix(state.Parameters()))), &report, model);
  return report;
}

/// A gain of this share of the cost moves a model of a thousand points by a thirtieth of its standard deviation.
constexpr double kHookTolerance = 1e-6;

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
  options.relative_tolerance = kHookTolerance;
  const Eigen::VectorXd before = RowResiduals<Model>(points, *model);
  Matrix3Parameters refined = *model;
  const Eigen::VectorXd near = (before.array() <= kRefineReach * loss.scale).template cast<double>();
  refine(points, near.cwiseProduct(weights), options, &refined);
  if (refined == *model || !refined.allFinite()) return false;
  // Counted again in the points' own coordinates: near a minimum the refinement's gain may be its rounding.
  const Eigen::VectorXd after = RowResiduals<Model>(points, refined);
  if (!(Cost(after, weights, loss) < Cost(before, weights, loss))) return false;
  *model = refined;
  return true;
}

}  // namespace

RefineReport RefineHomography(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                              Matrix3Parameters* model) {
  const auto to = [](const PairNormalization& n, const Eigen::Matrix3d& h) -> Eigen::Matrix3d {
    return n.second.Matrix() * h * n.first.Inverse();
  };
  const auto back = [](const PairNormalization& n, const Eigen::Matrix3d& h) -> Eigen::Matrix3d {
    return n.second.Inverse() * h * n.first.Matrix();
  };
  return RefineNormalized<HomographyManifold, HomographySampsonResiduals>(points, weights, options, 4, to, back, model);
}

RefineReport RefineFundamental(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                               Matrix3Parameters* model) {
  const auto to = [](const PairNormalization& n, const Eigen::Matrix3d& f) -> Eigen::Matrix3d {
    return n.second.Inverse().transpose() * f * n.first.Inverse();
  };
  const auto back = [](const PairNormalization& n, const Eigen::Matrix3d& f) -> Eigen::Matrix3d {
    return n.second.Matrix().transpose() * f * n.first.Matrix();
  };
  return RefineNormalized<FundamentalManifold, SampsonResiduals>(points, weights, options, 7, to, back, model);
}

RefineReport RefineEssential(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                             Matrix3Parameters* model) {
  RefineReport report;
  PairNormalization identity;
  WeightedPairs pairs;
  report.status = Prepare(points, weights, 5, false, *model, &identity, &pairs);
  if (report.status != Status::kOk) return report;
  EssentialManifold state = EssentialManifold::From(*model);
  if (MinimizeOn(RobustCost<SampsonResiduals>(pairs, options.loss), options, &state, &report))
    Keep(state.Parameters(), &report, model);
  return report;
}

RefineReport RefineFocal(UnknownFocal unknown, const PointMatrix& points, const Eigen::VectorXd& weights,
                         const RefineOptions& options, const FocalPriors& priors, FocalParameters* model) {
  return RefineOnFocalManifold<false>(unknown, points, weights, options, priors, model);
}

RefineReport RefineWithFocal(UnknownFocal unknown, const PointMatrix& points, const Eigen::VectorXd& weights,
                             const RefineOptions& options, FocalParameters* model) {
  return RefineOnFocalManifold<true>(unknown, points, weights, options, {}, model);
}

double ResidualVariance(const RobustLoss& loss, const double* distances, const double* weights, int count, int free) {
  double pulls = 0.0, slopes = 0.0, share = 0.0, squares = 0.0;
  for (int i = 0; i < count; ++i) {
    const double pull = distances[i] * loss.Weight(distances[i] * distances[i]);
    pulls += weights[i] * weights[i] * pull * pull;
    slopes += weights[i] * SlopeOfPull(loss, distances[i]);
    if (pull == 0.0) continue;
    share += weights[i];
    squares += weights[i] * weights[i];
  }
  if (!(slopes > 0.0) || !(squares > 0.0)) return 0.0;
  // So many points of equal weight say as much as these.
  const double effective = share * share / squares;
  return effective > free ? pulls / slopes * effective / (effective - free) : 0.0;
}

// The models' hooks (ransac/model_hooks.h).

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

}  // namespace diffsac
