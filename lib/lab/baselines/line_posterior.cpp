#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>
#include <vector>

#include "diffsac/consensus/sample_consensus_impl.h"
#include "diffsac/consensus/samplers/minimal_sampler.h"
#include "diffsac/consensus/scores/mixture.h"
#include "diffsac/consensus/scores/scorer.h"
#include "diffsac/core/options.h"
#include "diffsac/estimators/robust_estimator.h"
#include "diffsac/estimators/task_dispatch.h"
#include "lab/config/estimator_registry.h"

namespace diffsac {
namespace {

/// What the posterior is told about the generator, beyond the points: see docs/generators.md.
struct LinePosteriorOptions {
  double side = 10.0;               ///< The picture is [0, side]².
  double min_extent = 5.0;          ///< Shortest chord.
  double sigma_factor = 1.0 / 3.0;  ///< σ as a multiple of the problem's ε.
  double tolerance_deg = 0.5;       ///< Of the accuracy that is maximised, as the metric's.
  int max_iterations = 5000;  ///< Pairs that the search for modes starts from; all of them when there are no more.
  int candidates = 30;        ///< Hypotheses, best first by MSAC, that are refined to modes.
  void Bind(OptionsBinder& b);
};

/// The Bayes estimate of a line under the generator itself (`synthetic_line`, `through_point`, Gaussian noise, uniform
/// outliers): what an estimator that knows everything but the line, the inliers and their share can reach. A reference
/// for tables, as the oracle is, and useless on other data: no learned or exhaustive search can be expected to beat it.
///
/// Likelihood of a line: Π [w/L · N(r; σ) + (1 − w)/side²], with L its chord and the share of inliers w integrated out
/// over (0, 1); prior: L for chords of at least min_extent (a line through a uniform point). The modes are refined by
/// expectation maximisation and each is integrated on a grid of 41 × 17 over ±6 standard deviations of the angle and ±4
/// of the offset at the centroid. The answer is the line that maximises the expected accuracy, 1 − error/tolerance_deg
/// where positive, under the posterior; the score is that expectation times N.
class LinePosteriorEstimator : public RobustEstimator {
 public:
  explicit LinePosteriorEstimator(const LinePosteriorOptions& options) : options_(options) { CheckOptions(options); }
  Estimate DoRun(const Problem& problem, std::uint64_t seed) const override;

 private:
  LinePosteriorOptions options_;
};

constexpr int kShares = 24;
using Shares = Eigen::Array<double, kShares, 1>;

/// Length of the line inside [0, side]².
double ChordLength(const Line::Parameters& line, double side) {
  double low = -std::numeric_limits<double>::infinity(), high = -low;
  for (int axis = 0; axis < 2; ++axis) {
    const double base = -line[2] * line[axis], direction = axis == 0 ? -line[1] : line[0];
    if (std::abs(direction) < 1e-12) {
      if (base < 0.0 || base > side) return 0.0;
      continue;
    }
    const auto [near, far] = std::minmax({-base / direction, (side - base) / direction});
    low = std::max(low, near);
    high = std::min(high, far);
  }
  return std::max(0.0, high - low);
}

/// A line given by the angle of its normal and its distance from a fixed centre.
Line::Parameters LineAt(double angle, double offset, const Eigen::Vector2d& center) {
  const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
  return {normal[0], normal[1], offset - normal.dot(center)};
}

class Posterior {
 public:
  Posterior(const PointMatrix& points, double sigma, const LinePosteriorOptions& options)
      : options_(options), sigma_(sigma), scorer_(points) {
    for (int i = 0; i < kShares; ++i) shares_[i] = (i + 0.5) / kShares;
  }

  /// log of likelihood × prior, w integrated out; −∞ where the prior is 0.
  double LogDensity(const Line::Parameters& line) const {
    const double chord = ChordLength(line, options_.side);
    if (chord < options_.min_extent) return -std::numeric_limits<double>::infinity();
    constexpr double kSqrtTwoPi = 2.50662827463100050242;
    const double ratio = options_.side * options_.side / (chord * kSqrtTwoPi * sigma_);
    const Eigen::ArrayXd squares = scorer_.Residuals(line).array().square() * (-0.5 / (sigma_ * sigma_));
    Shares logs = static_cast<double>(squares.size()) * (1.0 - shares_).log();
    Shares product = Shares::Ones();
    for (double exponent : squares) {
      if (exponent < -40.0) continue;
      product *= 1.0 + shares_ / (1.0 - shares_) * (ratio * std::exp(exponent));
      if (product.maxCoeff() > 1e200) {
        logs += product.log();
        product.setOnes();
      }
    }
    logs += product.log();
    const double top = logs.maxCoeff();
    return top + std::log((logs - top).exp().mean()) + std::log(chord);
  }

  const Scorer<Line>& scorer() const { return scorer_; }
  double sigma() const { return sigma_; }

 private:
  const LinePosteriorOptions& options_;
  double sigma_;
  Scorer<Line> scorer_;
  Shares shares_;
};

/// The posterior on one column of a mode's grid: one angle, offsets integrated out.
struct Slice {
  double angle;
  double log_mass;
  Line::Parameters mean;  ///< The line of this angle with the mean offset.
};

/// Appends the slices of one mode.
void IntegrateMode(const Posterior& posterior, const Line::Parameters& mode, double inlier_threshold,
                   std::vector<Slice>* slices) {
  constexpr int kAngles = 20, kOffsets = 8;
  const PointMatrix& points = posterior.scorer().points();
  const Eigen::VectorXd near = (posterior.scorer().Residuals(mode).array() <= inlier_threshold).cast<double>();
  const Eigen::Vector2d center = points.transpose() * near / std::max(1.0, near.sum());
  const Eigen::VectorXd positions = (points.rowwise() - center.transpose()) * Eigen::Vector2d(-mode[1], mode[0]);
  const double spread = std::sqrt(std::max(1e-6, near.dot(positions.cwiseAbs2())));
  const double angle_step = 6.0 * posterior.sigma() / spread / kAngles;
  const double offset_step = 4.0 * posterior.sigma() / std::sqrt(std::max(2.0, near.sum())) / kOffsets;
  const double angle = std::atan2(mode[1], mode[0]), offset = mode.head<2>().dot(center) + mode[2];
  const double reference = posterior.LogDensity(mode);
  if (!std::isfinite(reference)) return;
  for (int i = -kAngles; i <= kAngles; ++i) {
    double mass = 0.0, offsets = 0.0;
    for (int j = -kOffsets; j <= kOffsets; ++j) {
      const auto line = LineAt(angle + i * angle_step, offset + j * offset_step, center);
      const double density = std::exp(posterior.LogDensity(line) - reference);
      mass += density;
      offsets += density * j * offset_step;
    }
    if (!(mass > 0.0) || !std::isfinite(mass)) continue;
    slices->push_back({angle + i * angle_step, reference + std::log(mass * angle_step * offset_step),
                       LineAt(angle + i * angle_step, offset + offsets / mass, center)});
  }
}

/// Angle between two lines given by their normals' angles, in radians, in [0, π/2].
double AngleBetween(double a, double b) {
  const double difference = std::abs(std::remainder(a - b, std::numbers::pi));
  return std::min(difference, std::numbers::pi - difference);
}

/// Two lines whose grids would cover the same posterior mass.
bool SameMode(const Line::Parameters& a, const Line::Parameters& b, const Eigen::Vector2d& center, double sigma) {
  const double sign = a.head<2>().dot(b.head<2>()) < 0.0 ? -1.0 : 1.0;
  const Line::Parameters difference = a - sign * b;
  const double at_center = std::abs(difference.head<2>().dot(center) + difference[2]);
  return AngleBetweenDegrees(a, b) < 1.0 && at_center < 3.0 * sigma;
}

std::vector<Line::Parameters> FindModes(const Posterior& posterior, const Problem& problem,
                                        const std::vector<int>& sets, int candidates) {
  const Scorer<Line>& scorer = posterior.scorer();
  const Score msac(ScoreKind::kMsac, problem.inlier_threshold, posterior.sigma(), 1.0);
  BestHypotheses<Line> best(scorer, problem.inlier_threshold, candidates);
  Line::Parameters solved;
  for (std::size_t start = 0; start < sets.size(); start += Line::kMinimalSize)
    if (Line::SolveMinimal(problem.points, sets.data() + start, &solved) > 0)
      best.Offer(solved, scorer(solved, msac, best.bar()));

  const Mixture mixture = MakeMixture(problem.points, problem.inlier_threshold, posterior.sigma());
  const Eigen::Vector2d center = problem.points.colwise().mean();
  std::vector<Line::Parameters> modes;
  for (const auto& entry : best.entries()) {
    Line::Parameters mode = entry.model;
    const double inliers = static_cast<double>(std::count(entry.inliers.begin(), entry.inliers.end(), 1));
    MixtureRefit<Line>(problem.points, mixture, inliers / scorer.size(), &mode);
    const auto same = [&](const Line::Parameters& other) { return SameMode(mode, other, center, posterior.sigma()); };
    if (std::none_of(modes.begin(), modes.end(), same)) modes.push_back(mode);
  }
  return modes;
}

Estimate EstimatePosterior(const SolverSpace& space, const LinePosteriorOptions& options, std::uint64_t seed) {
  const Problem& problem = space.problem();
  Estimate estimate;
  if (!(problem.inlier_threshold > 0.0)) return estimate;
  const int size = static_cast<int>(problem.points.rows());
  const std::vector<int> sets = DrawAllOrSome(size, 2, options.max_iterations, Rng(seed));
  estimate.report.hypotheses = static_cast<int>(sets.size() / 2);

  const Posterior posterior(problem.points, options.sigma_factor * problem.inlier_threshold, options);
  std::vector<Slice> slices;
  for (const auto& mode : FindModes(posterior, problem, sets, options.candidates))
    IntegrateMode(posterior, mode, problem.inlier_threshold, &slices);
  if (slices.empty()) return estimate;
  double top = -std::numeric_limits<double>::infinity(), total = 0.0;
  for (const Slice& slice : slices) top = std::max(top, slice.log_mass);
  for (const Slice& slice : slices) total += std::exp(slice.log_mass - top);
  const double tolerance = options.tolerance_deg * std::numbers::pi / 180.0;
  double best = -1.0;
  for (const Slice& candidate : slices) {
    double expected = 0.0;
    for (const Slice& slice : slices)
      expected +=
          std::exp(slice.log_mass - top) * std::max(0.0, 1.0 - AngleBetween(candidate.angle, slice.angle) / tolerance);
    if (!(expected > best)) continue;
    best = expected;
    AcceptModel<Line>(space, candidate.mean, &estimate);
  }
  estimate.score = size * best / total;
  return estimate;
}

void LinePosteriorOptions::Bind(OptionsBinder& b) {
  b.Field("side", side, Positive()).Help("the picture is [0, side]²");
  b.Field("min_extent", min_extent, AtLeast(0.0)).Help("shortest chord");
  b.Field("sigma_factor", sigma_factor, Positive()).Help("σ as a multiple of the problem's ε");
  b.Field("tolerance_deg", tolerance_deg, Positive()).Help("of the accuracy that is maximised, as the metric's");
  b.Field("max_iterations", max_iterations, Within(1, 1e7))
      .Help("pairs that the search for modes starts from; all of them where there are no more");
  b.Field("candidates", candidates, Within(2, 1e5)).Help("hypotheses, best first by MSAC, that are refined to modes");
}

Estimate LinePosteriorEstimator::DoRun(const Problem& problem, std::uint64_t seed) const {
  return TimedEstimate(problem, [&]<MinimalModel Model>(const SolverSpace& space) {
    if constexpr (std::is_same_v<Model, Line>) return EstimatePosterior(space, options_, seed);
    return Estimate{};
  });
}

const RegisteredEstimator<LinePosteriorOptions> kLinePosterior(
    "line_posterior",
    "Lines: a reference, as `oracle` is: the Bayes estimate under the generator (`through_point`, Gaussian noise, "
    "uniform "
    "outliers).",
    [](Task task) {
      if (task != Task::kLine) throw Error("line_posterior estimates lines only");
      return LinePosteriorOptions();
    },
    [](const LinePosteriorOptions& options) { return std::make_unique<LinePosteriorEstimator>(options); });

}  // namespace
}  // namespace diffsac
