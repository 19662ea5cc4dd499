#include "diffsac/methods/weighted_method.h"

#include <torch/torch.h>

#include <utility>

#include "diffsac/consensus/weighted_source.h"
#include "diffsac/core/parallel.h"
#include "diffsac/methods/network_batch.h"

namespace diffsac {
namespace {

PointFeatures FeaturesOf(const LearnedWeights& weights, int preference_draws) {
  auto options = weights.feature_options;
  if (preference_draws > 0) options.preference_draws = preference_draws;
  return PointFeatures(options, weights.task);
}

}  // namespace

void WeightedMethodOptions::Bind(OptionsBinder& b) {
  b.Field("hypotheses", hypotheses, Within(0, 1000000));
  b.Field("weighted_fit", weighted_fit);
  b.Field("fundamental_points", fundamental_points, Within(7, 8));
  b.Field("feature_hypotheses", feature_hypotheses);
  b.Field("preference_draws", preference_draws, AtLeast(0));
  b.Field("batch", batch, Within(1, 4096));
  b.Group("consensus", consensus);
  b.Require(hypotheses > 0 || weighted_fit, "hypotheses", "at least 1 where weighted_fit is false");
}

WeightedMethodOptions DefaultWeightedOptions(const std::string& method) {
  WeightedMethodOptions options;
  if (method == "clnet") {
    options.hypotheses = 0;
    options.weighted_fit = true;
  }
  return options;
}

WeightedMethod::WeightedMethod(std::shared_ptr<const LearnedWeights> weights, WeightedMethodOptions options,
                               int threads)
    : weights_(std::move(weights)),
      options_(std::move(options)),
      threads_(threads),
      features_(FeaturesOf(*weights_, options_.preference_draws)) {}

diffsac::Estimate WeightedMethod::Estimate(const Problem& problem, std::uint64_t seed) const {
  return EstimateBatch({&problem, 1}, {&seed, 1})[0];
}

std::vector<WeightedMethod::Prediction> WeightedMethod::Predict(std::span<const Problem* const> problems,
                                                                std::span<const std::uint64_t> seeds,
                                                                double* ms_features, double* ms_network) const {
  const c10::InferenceMode inference;
  const auto start = MethodClock::now();
  const std::int64_t count = static_cast<std::int64_t>(problems.size());
  std::vector<Prediction> predictions(problems.size());
  ParallelFor(count, threads_, [&](std::int64_t b) {
    predictions[b].features = features_.Compute(*problems[b], Rng(seeds[b]).Fork("features"));
  });
  *ms_features = MillisecondsSince(start);

  const auto network_start = MethodClock::now();
  std::vector<const FeatureSet*> sets;
  for (const auto& prediction : predictions) sets.push_back(&prediction.features);
  const auto batch = MakePointBatch(sets);
  const auto weights =
      weights_->network->Weights(batch.To(weights_->device)).to(torch::kCPU, torch::kDouble).contiguous();
  for (std::int64_t b = 0; b < count; ++b) {
    const double* values = weights.data_ptr<double>() + b * batch.max_points();
    predictions[b].weights.assign(values, values + batch.lengths[b]);
  }
  *ms_network = MillisecondsSince(network_start);
  return predictions;
}

template <MinimalModel Model>
ConsensusResult WeightedMethod::Consensus(const Problem& problem, const Prediction& prediction, const Rng& rng) const {
  const SolverSpace space(problem);
  const int points = static_cast<int>(space.points().rows());
  std::vector<int> sets;
  if (options_.hypotheses > 0)
    WeightedSource(prediction.weights)
        .Draw(points, Model::kMinimalSize, options_.hypotheses, rng.Fork("minimal_sets"), &sets);
  ConsensusHints hints;
  if (options_.feature_hypotheses) hints.models = prediction.features.models;
  if (options_.weighted_fit) hints.fit_weights = Eigen::Map<const Eigen::VectorXd>(prediction.weights.data(), points);
  return SampleConsensus<Model>(space.points(), space.threshold(), sets, options_.consensus, rng.Fork("consensus"),
                                hints);
}

diffsac::Estimate WeightedMethod::EstimateFrom(const Problem& problem, const Prediction& prediction,
                                               std::uint64_t seed) const {
  const auto start = MethodClock::now();
  const Rng rng(seed);
  auto result = DispatchSetSize(problem.task, options_.fundamental_points,
                                [&]<class Model>() { return Consensus<Model>(problem, prediction, rng); });
  return EstimateOf(std::move(result), prediction.features.hypotheses, start);
}

std::vector<diffsac::Estimate> WeightedMethod::EstimateBatch(std::span<const Problem> problems,
                                                             std::span<const std::uint64_t> seeds) const {
  const auto predict = [&](std::span<const Problem* const> good, std::span<const std::uint64_t> good_seeds,
                           double* ms_features,
                           double* ms_network) { return Predict(good, good_seeds, ms_features, ms_network); };
  const auto finish = [&](const Problem& problem, const Prediction& prediction, std::uint64_t seed) {
    return EstimateFrom(problem, prediction, seed);
  };
  return EstimateTogether(problems, seeds, threads_, predict, finish);
}

}  // namespace diffsac
