#include "diffsac/estimate/learned_estimator.h"

#include <algorithm>
#include <utility>

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/estimation_priors.h"
#include "diffsac/estimate/photograph_cameras.h"
#include "diffsac/estimate/point_rows.h"
#include "diffsac/estimate/task_dispatch.h"
#include "diffsac/estimate/vanishing_point_chooser.h"

namespace diffsac {
namespace {

PointFeatures FeaturesOf(const LearnedModel& network, int residual_draws) {
  auto options = network.feature_options;
  if (residual_draws > 0) options.residual_draws = residual_draws;
  return PointFeatures(options, network.task);
}

/// What was said of some of `count` points.
Prediction RowsOf(const Prediction& whole, const std::vector<int>& rows, Eigen::Index count) {
  Prediction part;
  if (!whole.weights.empty())
    for (const int i : rows) part.weights.push_back(whole.weights[i]);
  for (std::size_t first = 0; first < whole.confidences.size(); first += static_cast<std::size_t>(count))
    for (const int i : rows) part.confidences.push_back(whole.confidences[first + static_cast<std::size_t>(i)]);
  return part;
}

}  // namespace

Eigen::VectorXd InlierPriors(const NormalizedProblem& space, const std::vector<float>& of_network, PriorSource source) {
  const Eigen::VectorXd network =
      Eigen::Map<const Eigen::VectorXf>(of_network.data(), static_cast<Eigen::Index>(of_network.size())).cast<double>();
  const Eigen::VectorXd& of_ratio = space.match_probabilities();
  if (of_ratio.size() == 0 || source == PriorSource::kNetwork) return network;
  if (source == PriorSource::kRatio) return of_ratio;
  return (of_ratio.array() * network.array()).sqrt();
}

LearnedEstimator::LearnedEstimator(std::shared_ptr<const LearnedModel> network,
                                   std::shared_ptr<const LearnedOptions> options, int threads)
    : network_(std::move(network)),
      options_(std::move(options)),
      instances_(options_->instances),
      threads_(threads),
      model_(ModelFromString(network_->task, options_->model)),
      features_(FeaturesOf(*network_, options_->residual_draws)) {
  LoadChooser(&instances_);
}

Estimate LearnedEstimator::DoRun(const NormalizedProblem& space, std::uint64_t seed) const {
  const auto start = EstimatorClock::now();
  Estimate estimate;
  estimate.status = Check(space);
  if (estimate.status != Status::kOk) return estimate;
  const Timed timed = PredictTimed({&space, 1}, {&seed, 1});
  estimate = EstimateFrom(space, timed.predictions.front(), seed);
  estimate.stats.ms_features = timed.ms_features;
  estimate.stats.ms_network = timed.ms_network;
  estimate.stats.ms_total = MillisecondsSince(start);
  return estimate;
}

std::vector<Estimate> LearnedEstimator::DoRunBatch(std::span<const NormalizedProblem> given,
                                                   std::span<const std::uint64_t> seeds) const {
  const auto start = EstimatorClock::now();
  std::vector<Estimate> estimates(given.size());
  if (!network_->batches) {
    ParallelFor(static_cast<std::int64_t>(given.size()), threads_,
                [&](std::int64_t i) { estimates[i] = DoRun(given[i], seeds[i]); });
    return estimates;
  }
  std::vector<NormalizedProblem> spaces;
  std::vector<std::uint64_t> fit_seeds;
  std::vector<std::size_t> places;  // of those that can be estimated from
  for (std::size_t i = 0; i < given.size(); ++i) {
    estimates[i].status = Check(given[i]);
    if (estimates[i].status != Status::kOk) continue;
    spaces.push_back(given[i]);
    fit_seeds.push_back(seeds[i]);
    places.push_back(i);
  }
  if (places.empty()) return estimates;
  const Timed timed = PredictTimed(spaces, fit_seeds);
  ParallelFor(static_cast<std::int64_t>(places.size()), threads_, [&](std::int64_t b) {
    estimates[places[b]] = EstimateFrom(spaces[b], timed.predictions[b], fit_seeds[b]);
  });
  const double share = 1.0 / static_cast<double>(places.size());  // times of a batch are shared equally
  const double ms_total = MillisecondsSince(start);
  for (const std::size_t place : places) {
    auto& report = estimates[place].stats;
    report.ms_features = timed.ms_features * share;
    report.ms_network = timed.ms_network * share;
    report.ms_total = ms_total * share;
  }
  return estimates;
}

std::vector<FeatureSet> LearnedEstimator::ComputeFeatures(std::span<const NormalizedProblem> spaces,
                                                          std::span<const std::uint64_t> seeds) const {
  std::vector<FeatureSet> sets(spaces.size());
  ParallelFor(static_cast<std::int64_t>(spaces.size()), threads_,
              [&](std::int64_t b) { sets[b] = features_.Compute(spaces[b], Rng(seeds[b]).Fork("features")); });
  return sets;
}

LearnedEstimator::Timed LearnedEstimator::PredictTimed(std::span<const NormalizedProblem> spaces,
                                                       std::span<const std::uint64_t> seeds) const {
  Timed timed;
  const auto start = EstimatorClock::now();
  auto sets = ComputeFeatures(spaces, seeds);
  timed.ms_features = MillisecondsSince(start);

  const auto network_start = EstimatorClock::now();
  for (auto& features : sets) timed.predictions.push_back({std::move(features), {}, {}});
  const std::size_t part = network_->problems_a_call > 0 ? network_->problems_a_call : spaces.size();
  const std::span<Prediction> predictions(timed.predictions);
  ParallelFor(static_cast<std::int64_t>((spaces.size() + part - 1) / part), threads_, [&](std::int64_t p) {
    const std::size_t begin = part * static_cast<std::size_t>(p), count = std::min(part, spaces.size() - begin);
    Infer(spaces.subspan(begin, count), seeds.subspan(begin, count), predictions.subspan(begin, count));
  });
  timed.ms_network = MillisecondsSince(network_start);
  return timed;
}

std::vector<Prediction> LearnedEstimator::Predict(std::span<const NormalizedProblem> spaces,
                                                  std::span<const std::uint64_t> seeds) const {
  return PredictTimed(spaces, seeds).predictions;
}

EstimationPriors LearnedEstimator::PriorsOf(const NormalizedProblem& space, const Prediction& prediction) const {
  EstimationPriors priors = PriorsOfProblem(space, options_->consensus);
  // Where there are no ratios, what a network says in their place makes scores worse (docs/experiments.md).
  const bool has_source =
      options_->inlier_prior_of == PriorSource::kNetwork || space.problem().snn_ratio.size() == space.points().rows();
  if (options_->consensus.inlier_prior_power > 0.0 && !prediction.weights.empty() && has_source)
    priors.inlier_priors = InlierPriors(space, prediction.weights, options_->inlier_prior_of);
  if (options_->feature_hypotheses)
    priors.models.insert(priors.models.end(), prediction.features.models.begin(), prediction.features.models.end());
  if (options_->weighted_fit)
    priors.fit_weights =
        Eigen::Map<const Eigen::VectorXf>(prediction.weights.data(), space.points().rows()).cast<double>();
  return priors;
}

std::unique_ptr<MinimalSampler> LearnedEstimator::MakeSamplerOfRows(const Guidance& whole,
                                                                    const std::vector<int>& rows) const {
  /// A sampler with what it may borrow.
  class SamplerOfPart : public MinimalSampler {
   public:
    SamplerOfPart(const Guidance& whole, const std::vector<int>& rows)
        : points_(whole.space, rows), prediction_(RowsOf(whole.prediction, rows, whole.space.points().rows())) {}
    void Make(const LearnedEstimator& method, const Guidance& whole) {
      sampler_ = method.MakeSampler({points_.space(), prediction_, whole.set_size, whole.rng});
    }
    bool Next(std::span<int> set) override { return sampler_->Next(set); }

   private:
    PointRows points_;
    Prediction prediction_;
    std::unique_ptr<MinimalSampler> sampler_;
  };
  auto sampler = std::make_unique<SamplerOfPart>(whole, rows);
  sampler->Make(*this, whole);
  return sampler;
}

template <MinimalModel Model>
Estimate LearnedEstimator::Consensus(const NormalizedProblem& space, const Prediction& prediction,
                                     const Rng& rng) const {
  const EstimationPriors priors = PriorsOf(space, prediction);
  if (instances_.Several()) {
    const auto sampler_of = [&](const std::vector<int>& rows, int search) {
      return MakeSamplerOfRows({space, prediction, Model::kMinimalSize, search == 0 ? rng : rng.Fork("search", search)},
                               rows);
    };
    return EstimateOf(FindInstances<Model>(space.points(), space.threshold(), sampler_of, options_->consensus,
                                           instances_, rng.Fork("consensus"), priors));
  }
  const auto sampler = MakeSampler({space, prediction, Model::kMinimalSize, rng});
  const ConsensusOptions consensus = OptionsOfProblem(space, options_->consensus);
  ConsensusResult found = SearchCheckedPoints<Model>(space.points(), space.threshold(), *sampler, consensus,
                                                     rng.Fork("consensus"), priors, options_->search_threads);
  if (options_->photographs) PutCameraBehind(space, rng, &found);
  return EstimateOf(space, std::move(found));
}

Estimate LearnedEstimator::EstimateFrom(const NormalizedProblem& space, const Prediction& prediction,
                                        std::uint64_t seed) const {
  const auto start = EstimatorClock::now();
  const Rng rng(seed);
  Estimate estimate = DispatchModel(model_, [&]<class Model>() { return Consensus<Model>(space, prediction, rng); });
  estimate.stats.hypotheses += prediction.features.hypotheses;
  estimate.inlier_probabilities = prediction.weights;
  estimate.stats.ms_consensus = MillisecondsSince(start);
  return estimate;
}

}  // namespace diffsac
