#include "diffsac/ransac/search.h"

#include <stdexcept>
#include <string>

#include "diffsac/geometry/point_spread.h"
#include "diffsac/ransac/samplers/weighted_sampler.h"

namespace diffsac::ransac::internal {
namespace {

void Require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("ransac::Search: " + what);
}

void CheckOptions(const Options& options) {
  Require(options.max_residual > 0.0 && std::isfinite(options.max_residual), "max_residual must be given, above 0");
  if (options.min_residual)
    Require(*options.min_residual > 0.0 && *options.min_residual <= options.max_residual,
            "min_residual must be above 0 and at most max_residual");
  Require(options.max_iterations >= 1, "max_iterations must be at least 1");
  Require(options.min_iterations >= 0, "min_iterations must be at least 0");
  Require(options.confidence >= 0.0 && options.confidence < 1.0, "confidence must be in [0, 1)");
  Require(options.num_threads >= 0, "num_threads must be at least 0");
}

void CheckValues(const Eigen::VectorXd& values, Eigen::Index points, const char* what) {
  Require(values.size() == 0 || values.size() == points, std::string(what) + " must be a value for each point");
  Require((values.array() >= 0.0).all(), std::string(what) + " must be at least 0");
}

ConsensusOptions OverScales(const Options& options) {
  ConsensusOptions consensus;
  consensus.score = consensus.final_score = ScoreKind::kSigmaMarginalisedMsac;
  consensus.threshold = ThresholdKind::kAdaptive;
  consensus.greatest_scale = options.max_residual;
  consensus.least_scale = options.min_residual.value_or(0.0);
  consensus.refit = Refit::kNone;
  consensus.refit_rounds = 5;
  consensus.refit_threshold_factor = 1.2;
  consensus.refit_candidates = 10;
  consensus.num_finalists = 3;
  consensus.stopping = Stopping::kConfidence;
  consensus.confidence = options.confidence;
  consensus.min_iterations = options.min_iterations;
  consensus.max_iterations = options.max_iterations;
  return consensus;
}

/// Of some rows; empty of empty.
Eigen::VectorXd Of(const Eigen::VectorXd& values, const std::vector<int>& rows) {
  return values.size() == 0 ? Eigen::VectorXd() : Eigen::VectorXd(values(rows));
}

}  // namespace

Setting::Setting(const PointMatrix& all, int dimension, int set_size, int parameters, const Options& options,
                 const PointGuidance& guidance)
    : consensus(OverScales(options)), rng(options.seed) {
  CheckOptions(options);
  Require(all.cols() == dimension || all.rows() == 0, "points must have " + std::to_string(dimension) + " columns");
  CheckValues(guidance.inlier_probabilities, all.rows(), "inlier_probabilities");
  CheckValues(guidance.draw_weights, all.rows(), "draw_weights");
  if (options.initial_model) {
    Require(options.initial_model->size() == parameters, "initial_model must be Model::Parameters");
    priors.models = {*options.initial_model};
  }
  for (int i = 0; i < static_cast<int>(all.rows()); ++i)
    if (all.row(i).allFinite()) rows.push_back(i);
  points = all(rows, Eigen::all);
  priors.inlier_priors = Of(guidance.inlier_probabilities, rows);
  consensus.inlier_prior_power = priors.inlier_priors.size() > 0 ? 1.0 : 0.0;
  Eigen::VectorXd weights = guidance.draw_weights.size() > 0 ? Of(guidance.draw_weights, rows) : priors.inlier_priors;
  // Weights that are all 0 say nothing.
  if (weights.size() > 0 && !(weights.maxCoeff() > 0.0)) weights.resize(0);
  const int size = static_cast<int>(rows.size());
  const Rng draws = rng.Fork("minimal_sets");
  if (weights.size() > 0)
    sampler = std::make_unique<WeightedSampler>(std::span(weights.data(), rows.size()), set_size, draws);
  else
    sampler = std::make_unique<UniformSampler>(size, set_size, draws);
  // Few points have fewer sets than are drawn at least: each once.
  if (Combinations(size, set_size) <= options.min_iterations) {
    sampler = std::make_unique<ExhaustiveSampler>(size, set_size);
    consensus.stopping = Stopping::kBudget;
  }
  stop.emplace(consensus, size, set_size, weights);
}

PointMatrix UnstructuredPoints(const PointMatrix& points, int count, Rng rng) {
  Eigen::RowVectorXd low = points.colwise().minCoeff(), width = points.colwise().maxCoeff() - low;
  if (points.cols() <= 3) {
    const PointSpread spread = SpreadOf(points);
    width.setConstant(spread.sides.maxCoeff());
    low = spread.centre.transpose() - 0.5 * width;
  }
  PointMatrix sample(count, points.cols());
  for (int i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < points.cols(); ++j) sample(i, j) = low[j] + width[j] * rng.Uniform();
  return sample;
}

}  // namespace diffsac::ransac::internal
