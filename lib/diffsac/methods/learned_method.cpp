#include "diffsac/methods/learned_method.h"

#include <algorithm>
#include <utility>

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "diffsac/methods/known_of_problem.h"
#include "diffsac/methods/point_rows.h"
#include "diffsac/methods/task_dispatch.h"

namespace diffsac {
namespace {

PointFeatures FeaturesOf(const LearnedModel& network, int preference_draws) {
  auto options = network.feature_options;
  if (preference_draws > 0) options.preference_draws = preference_draws;
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

/// Whose sets are known when the first is asked for.
class AskedSource : public HypothesisSource {
 public:
  using Ask = std::function<std::unique_ptr<HypothesisSource>()>;
  explicit AskedSource(Ask ask) : ask_(std::move(ask)) {}
  bool Next(std::span<int> set) override {
    if (source_ == nullptr) source_ = ask_();
    return source_->Next(set);
  }
  double LogMissed(const InlierSets& inliers) const override {
    return source_ != nullptr ? source_->LogMissed(inliers) : HypothesisSource::LogMissed(inliers);
  }
  std::int64_t DrawsUntil(const InlierSets& inliers, double log_miss) const override {
    return source_ != nullptr ? source_->DrawsUntil(inliers, log_miss)
                              : HypothesisSource::DrawsUntil(inliers, log_miss);
  }

 private:
  Ask ask_;
  std::unique_ptr<HypothesisSource> source_;
};

/// PROSAC's sets where the problem has a quality to order its points by, else uniform ones.
std::unique_ptr<HypothesisSource> FirstSource(SourceKind kind, const SolverSpace& space, int set_size, const Rng& rng) {
  const Eigen::VectorXd& quality = space.problem().quality;
  SourceOptions options;
  options.source = quality.size() == space.points().rows() ? kind : SourceKind::kUniform;
  return MakeHypothesisSource(options, space.points(), set_size, rng,
                              {quality.data(), static_cast<std::size_t>(quality.size())});
}

}  // namespace

Eigen::VectorXd InlierPriors(const Problem& problem, const std::vector<float>& of_network, PriorSource source) {
  const Eigen::VectorXd network =
      Eigen::Map<const Eigen::VectorXf>(of_network.data(), static_cast<Eigen::Index>(of_network.size())).cast<double>();
  if (problem.quality.size() != problem.points.rows() || source == PriorSource::kNetwork) return network;
  const Eigen::VectorXd of_ratio = problem.quality.unaryExpr(&InlierProbabilityOfRatio);
  if (source == PriorSource::kRatio) return of_ratio;
  return (of_ratio.array() * network.array()).sqrt();
}

void LearnedOptions::BindShared(OptionsBinder& b) {
  b.Field("feature_hypotheses", feature_hypotheses)
      .Help("score the hypotheses that the features were made from as well (they are paid for and counted)");
  b.Field("preference_draws", preference_draws, Within(0, 1e5))
      .Help("minimal sets that the preference features are drawn from, all counted in the budget; 0: as in training");
  b.Field("batch", batch, Within(1, 4096)).Help("problems a network call");
  b.Field("consensus", consensus).Help("score, local optimisation, stopping and refits");
  b.Field("structures", structures).Help("whether several models are looked for, and how");
  b.Field("inlier_prior_of", inlier_prior_of)
      .OnlyIf(consensus.inlier_prior_power > 0.0, "consensus.inlier_prior_power above 0")
      .Help("whose probabilities weigh the points in scores; both: their geometric mean");
  b.Field("first_sets", first_sets, Within(0, 1e6))
      .Help(
          "so many sets of first_source come first, and where the search is confident among them the network is not "
          "asked; sets are drawn 64, 128, 256 ... at a time, so 64, 192, 448 waste none");
  b.Field("first_source", first_source, {SourceKind::kUniform, SourceKind::kProsac})
      .OnlyIf(first_sets > 0, "first_sets above 0")
      .Help("prosac samples uniformly on data without a quality");
  const bool asks = feature_hypotheses || weighted_fit || structures.Several() ||
                    (consensus.inlier_prior_power > 0.0 && inlier_prior_of != PriorSource::kRatio);
  b.Require(
      first_sets == 0 || (consensus.stopping != Stopping::kBudget && !asks), "first_sets",
      "0 unless consensus.stopping is confidence or guided and nothing else asks the network (feature_hypotheses, a "
      "weighted fit, structures, inlier_prior_of)");
}

LearnedMethod::LearnedMethod(std::shared_ptr<const LearnedModel> network, const LearnedOptions& options, int threads)
    : network_(std::move(network)),
      options_(options),
      threads_(threads),
      model_(ModelFromString(network_->task, options_.model)),
      features_(FeaturesOf(*network_, options_.preference_draws)) {}

diffsac::Estimate LearnedMethod::DoEstimate(const Problem& problem, std::uint64_t seed) const {
  return EstimateOne(problem, seed);
}

diffsac::Estimate LearnedMethod::EstimateOne(const Problem& problem, std::uint64_t seed) const {
  const auto start = MethodClock::now();
  const SolverSpace space(problem);
  diffsac::Estimate estimate;
  estimate.status = Check(space);
  if (estimate.status != Status::kOk) return estimate;
  if (Lazy()) {
    estimate = EstimateLazily(space, seed);
  } else {
    const Timed timed = PredictTimed({&space, 1}, {&seed, 1});
    estimate = EstimateFrom(space, timed.predictions.front(), seed);
    estimate.report.ms_features = timed.ms_features;
    estimate.report.ms_denoise = timed.ms_network;
  }
  estimate.report.ms_total = MillisecondsSince(start);
  return estimate;
}

std::vector<diffsac::Estimate> LearnedMethod::DoEstimateBatch(std::span<const Problem* const> problems,
                                                              std::span<const std::uint64_t> seeds) const {
  const auto start = MethodClock::now();
  std::vector<diffsac::Estimate> estimates(problems.size());
  if (!Batches()) {
    ParallelFor(static_cast<std::int64_t>(problems.size()), threads_,
                [&](std::int64_t i) { estimates[i] = EstimateOne(*problems[i], seeds[i]); });
    return estimates;
  }
  std::vector<SolverSpace> spaces;
  std::vector<std::uint64_t> fit_seeds;
  std::vector<std::size_t> places;  // of those that can be estimated from
  for (std::size_t i = 0; i < problems.size(); ++i) {
    SolverSpace space(*problems[i]);
    estimates[i].status = Check(space);
    if (estimates[i].status != Status::kOk) continue;
    spaces.push_back(std::move(space));
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
    auto& report = estimates[place].report;
    report.ms_features = timed.ms_features * share;
    report.ms_denoise = timed.ms_network * share;
    report.ms_total = ms_total * share;
  }
  return estimates;
}

std::vector<FeatureSet> LearnedMethod::ComputeFeatures(std::span<const SolverSpace> spaces,
                                                       std::span<const std::uint64_t> seeds) const {
  std::vector<FeatureSet> sets(spaces.size());
  ParallelFor(static_cast<std::int64_t>(spaces.size()), threads_,
              [&](std::int64_t b) { sets[b] = features_.Compute(spaces[b], Rng(seeds[b]).Fork("features")); });
  return sets;
}

LearnedMethod::Timed LearnedMethod::PredictTimed(std::span<const SolverSpace> spaces,
                                                 std::span<const std::uint64_t> seeds) const {
  Timed timed;
  const auto start = MethodClock::now();
  auto sets = ComputeFeatures(spaces, seeds);
  timed.ms_features = MillisecondsSince(start);

  const auto network_start = MethodClock::now();
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

std::vector<Prediction> LearnedMethod::Predict(std::span<const SolverSpace> spaces,
                                               std::span<const std::uint64_t> seeds) const {
  return PredictTimed(spaces, seeds).predictions;
}

ConsensusHints LearnedMethod::HintsOf(const SolverSpace& space, const Prediction& prediction) const {
  ConsensusHints hints = KnownOf(space, options_.consensus);
  if (options_.consensus.inlier_prior_power > 0.0 && !prediction.weights.empty())
    hints.inlier_priors = InlierPriors(space.problem(), prediction.weights, options_.inlier_prior_of);
  if (options_.feature_hypotheses) hints.models = prediction.features.models;
  if (options_.weighted_fit)
    hints.fit_weights =
        Eigen::Map<const Eigen::VectorXf>(prediction.weights.data(), space.points().rows()).cast<double>();
  return hints;
}

std::unique_ptr<HypothesisSource> LearnedMethod::MakeSourceOfRows(const Guidance& whole,
                                                                  const std::vector<int>& rows) const {
  /// A source with what it may borrow.
  class SourceOfPart : public HypothesisSource {
   public:
    SourceOfPart(const Guidance& whole, const std::vector<int>& rows)
        : points_(whole.space, rows), prediction_(RowsOf(whole.prediction, rows, whole.space.points().rows())) {}
    void Make(const LearnedMethod& method, const Guidance& whole) {
      source_ = method.MakeSource({points_.space(), prediction_, whole.set_size, whole.rng});
    }
    bool Next(std::span<int> set) override { return source_->Next(set); }

   private:
    PointRows points_;
    Prediction prediction_;
    std::unique_ptr<HypothesisSource> source_;
  };
  auto source = std::make_unique<SourceOfPart>(whole, rows);
  source->Make(*this, whole);
  return source;
}

template <MinimalModel Model>
diffsac::Estimate LearnedMethod::Consensus(const SolverSpace& space, const Prediction& prediction,
                                           const Rng& rng) const {
  const ConsensusHints hints = HintsOf(space, prediction);
  if (options_.structures.Several()) {
    const auto source_of = [&](const std::vector<int>& rows, int search) {
      return MakeSourceOfRows({space, prediction, Model::kMinimalSize, search == 0 ? rng : rng.Fork("search", search)},
                              rows);
    };
    return EstimateOf(FindStructures<Model>(space.points(), space.threshold(), source_of, options_.consensus,
                                            options_.structures, rng.Fork("consensus"), hints));
  }
  const auto source = MakeSource({space, prediction, Model::kMinimalSize, rng});
  return EstimateOf(space, SearchCheckedPoints<Model>(space.points(), space.threshold(), *source, options_.consensus,
                                                      rng.Fork("consensus"), hints));
}

diffsac::Estimate LearnedMethod::EstimateFrom(const SolverSpace& space, const Prediction& prediction,
                                              std::uint64_t seed) const {
  const auto start = MethodClock::now();
  const Rng rng(seed);
  diffsac::Estimate estimate =
      DispatchModel(model_, [&]<class Model>() { return Consensus<Model>(space, prediction, rng); });
  estimate.report.hypotheses += prediction.features.hypotheses;
  estimate.inlier_probabilities = prediction.weights;
  estimate.report.ms_consensus = MillisecondsSince(start);
  return estimate;
}

template <MinimalModel Model>
diffsac::Estimate LearnedMethod::LazyConsensus(const SolverSpace& space, const Rng& rng,
                                               const std::function<const Prediction&()>& ask) const {
  SequenceSource sets;
  sets.Add(FirstSource(options_.first_source, space, Model::kMinimalSize, rng.Fork("first_sets")), options_.first_sets);
  sets.Add(std::make_unique<AskedSource>([&] { return MakeSource({space, ask(), Model::kMinimalSize, rng}); }));
  return EstimateOf(space, SearchCheckedPoints<Model>(space.points(), space.threshold(), sets, options_.consensus,
                                                      rng.Fork("consensus"), KnownOf(space, options_.consensus)));
}

diffsac::Estimate LearnedMethod::EstimateLazily(const SolverSpace& space, std::uint64_t seed) const {
  const auto start = MethodClock::now();
  Timed timed;
  double ms_asked = 0.0;
  const auto ask = [&]() -> const Prediction& {
    const auto asked = MethodClock::now();
    timed = PredictTimed({&space, 1}, {&seed, 1});
    ms_asked = MillisecondsSince(asked);
    return timed.predictions.front();
  };
  diffsac::Estimate estimate =
      DispatchModel(model_, [&]<class Model>() { return LazyConsensus<Model>(space, Rng(seed), ask); });
  estimate.report.ms_consensus = MillisecondsSince(start) - ms_asked;
  estimate.report.ms_features = timed.ms_features;
  estimate.report.ms_denoise = timed.ms_network;
  if (timed.predictions.empty()) return estimate;
  estimate.report.hypotheses += timed.predictions.front().features.hypotheses;
  estimate.inlier_probabilities = timed.predictions.front().weights;
  return estimate;
}

void CheckRowKeys(const Config& row, std::initializer_list<RowKey> keys) {
  for (const RowKey& key : keys) {
    if (key.acts || !row.Has(key.key)) continue;
    if (key.neutral != nullptr && row.Text(key.key) == key.neutral) continue;
    throw Error(row.Where(key.key) + ": changes nothing in this row: " + key.reason);
  }
}

void CheckSharedKeys(const Config& row, const LearnedModel& network) {
  const bool preference = network.feature_options.Has(PointFeature::kPreference);
  const char* features = "the network sees no preference features";
  CheckRowKeys(
      row, {{"feature_hypotheses", preference, features, "false"}, {"preference_draws", preference, features, "0"}});
}

}  // namespace diffsac
