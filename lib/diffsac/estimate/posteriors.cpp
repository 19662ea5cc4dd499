#include "diffsac/estimate/posteriors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diffsac/estimate/estimation_priors.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/model_hooks.h"

namespace diffsac {
namespace {

/// Residuals in the data's unit, and of how many dimensions each is the length.
struct Residuals {
  Eigen::VectorXd lengths;
  int dimension = 1;
};

Residuals ResidualsOf(const NormalizedProblem& space, const ModelParameters& parameters) {
  return DispatchTask(space.problem().task, [&]<MinimalModel Model>() -> Residuals {
    const typename Model::Parameters model = parameters;
    return {space.unit() * RowResiduals<Model>(space.points(), model), ResidualDimension<Model>()};
  });
}

/// σ of the noise, and up to where a residual may be noise, both in the data's unit.
struct Noise {
  explicit Noise(const Estimate& estimate) {
    constexpr double kLeast = 0.1;  // Of the inliers' threshold: of exact points noise is nothing.
    constexpr double kReach = 2.5;
    const double found = std::isfinite(estimate.sigma) ? estimate.sigma : estimate.inlier_threshold;
    sigma = std::max(found, kLeast * estimate.inlier_threshold);
    radius = std::max(estimate.inlier_threshold, kReach * sigma);
  }
  double sigma, radius;
};

/// What is known of points that have nothing to do with the model: how likely one is within `radius` of it.
double WrongShare(const Problem& problem, const Residuals& residuals, double radius) {
  constexpr double kReach = 4.0;  // The shell from the radius to so many of it.
  const auto beyond = static_cast<double>((residuals.lengths.array() > radius).count());
  const double near = beyond - static_cast<double>((residuals.lengths.array() > kReach * radius).count());
  const double local = near / std::max(beyond, 1.0) / (std::pow(kReach, residuals.dimension) - 1.0);
  const double anywhere =
      DispatchDescription(problem.task, [&]<class Description>() { return Description::ChanceShare(problem, radius); });
  return std::max(local, anywhere);
}

/// log of the density of a right point's residual over that of a wrong one's, of which `share` are within `radius`.
Eigen::ArrayXd LogLikelihoodRatios(const Residuals& residuals, double sigma, double radius, double share) {
  constexpr double kTail = 0.05, kWider = 3.0;
  const int d = residuals.dimension;
  const Eigen::ArrayXd squares = residuals.lengths.array().square();
  // The length of d Gaussian values has the density c r^(d−1)/s^d exp(−r²/2s²), a wrong point's d share
  // r^(d−1)/radius^d.
  const double c = (d == 2 ? 1.0 : std::sqrt(2.0 / std::numbers::pi)) / d;
  const auto of_noise = [&](double s) -> Eigen::ArrayXd {
    return std::pow(radius / s, d) * (squares * (-0.5 / (s * s))).exp();
  };
  const Eigen::ArrayXd ratio = c * ((1.0 - kTail) * of_noise(sigma) + kTail * of_noise(kWider * sigma));
  return (ratio / share + 1e-30).log();
}

Eigen::ArrayXd Logistic(const Eigen::ArrayXd& logits) { return 1.0 / (1.0 + (-logits).exp()); }

/// By how much the priors' log odds are moved for the likelihood to be greatest (expectation maximisation, with one
/// Newton step each), of up to kMost of the points.
double ShiftOf(const Eigen::ArrayXd& priors, const Eigen::ArrayXd& evidence) {
  constexpr Eigen::Index kMost = 500;
  constexpr int kRounds = 30;
  const Eigen::Index step = (priors.size() + kMost - 1) / kMost, count = (priors.size() + step - 1) / step;
  const auto every = Eigen::seqN(0, count, step);
  const Eigen::ArrayXd prior = priors(every), both = prior + evidence(every);
  double shift = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const double right = (Logistic(both + shift).sum() + 1.0) / (static_cast<double>(count) + 2.0);
    const Eigen::ArrayXd before = Logistic(prior + shift);
    const double move = (before.mean() - right) / std::max((before * (1.0 - before)).mean(), 1e-4);
    shift -= std::clamp(move, -2.0, 2.0);
    if (std::abs(move) < 1e-3) break;
  }
  return shift;
}

}  // namespace

MatchesWithinNoise WithinNoise(const NormalizedProblem& space, const Estimate& estimate) {
  const Residuals residuals = ResidualsOf(space, estimate.model);
  const double radius = Noise(estimate).radius;
  MatchesWithinNoise found{{}, WrongShare(space.problem(), residuals, radius)};
  for (const double length : residuals.lengths) found.inside.push_back(length <= radius);
  return found;
}

std::vector<float> PosteriorsOf(const NormalizedProblem& space, const Estimate& estimate) {
  constexpr double kLeast = 0.005;  // No prior is surer.
  if (!estimate.instances.empty()) return {};
  const Eigen::Index count = space.points().rows();
  std::vector<float> posteriors(static_cast<std::size_t>(count), 0.0F);
  if (estimate.status != Status::kOk) return posteriors;
  const Residuals residuals = ResidualsOf(space, estimate.model);
  const Noise noise(estimate);
  Eigen::ArrayXd priors = space.match_probabilities();
  if (priors.size() != count) priors = Eigen::ArrayXd::Constant(count, 0.3);
  priors = priors.max(kLeast).min(1.0 - kLeast);
  priors = (priors / (1.0 - priors)).log();
  const Eigen::ArrayXd evidence =
      LogLikelihoodRatios(residuals, noise.sigma, noise.radius, WrongShare(space.problem(), residuals, noise.radius));
  const Eigen::ArrayXd found = Logistic(priors + evidence + ShiftOf(priors, evidence));
  for (Eigen::Index i = 0; i < count; ++i) posteriors[static_cast<std::size_t>(i)] = static_cast<float>(found[i]);
  return posteriors;
}

}  // namespace diffsac
