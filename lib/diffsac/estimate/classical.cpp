#include "diffsac/estimate/classical.h"

#include <span>
#include <utility>

#include "diffsac/estimate/estimation_priors.h"
#include "diffsac/estimate/photograph_cameras.h"
#include "diffsac/estimate/point_rows.h"
#include "diffsac/estimate/task_dispatch.h"
#include "diffsac/estimate/vanishing_point_chooser.h"
#include "diffsac/ransac/model_hooks.h"

namespace diffsac {
namespace {

std::span<const double> Span(const Eigen::VectorXd& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

/// The sampler of one problem's sets. Every set, where the row asks for that and the budget holds them.
std::unique_ptr<MinimalSampler> SamplerOf(const NormalizedProblem& space, int set_size, const ClassicalOptions& options,
                                          const Rng& rng) {
  const PointMatrix& points = space.points();
  // Of points that say more or less, those that say most come first.
  const Eigen::VectorXd weights = PointWeights(space.problem()), by_weight = -weights;
  const Eigen::VectorXd& quality = weights.size() > 0 ? by_weight : space.problem().snn_ratio;
  const int size = static_cast<int>(points.rows());
  if (options.exhaustive && Combinations(size, set_size) <= options.max_iterations)
    return std::make_unique<ExhaustiveSampler>(size, set_size);
  const bool has_quality = quality.size() == size;
  MinimalSamplerOptions sampling = options.sampling;
  if (sampling.sampler == MinimalSamplerKind::kProsac && !has_quality) sampling.sampler = MinimalSamplerKind::kUniform;
  // Two names, because published tables were drawn with them.
  const Rng sets_rng = sampling.sampler == MinimalSamplerKind::kUniform ? rng.Fork("minimal_sets")
                                                                        : rng.Fork("consensus").Fork("minimal_sets");
  return MakeMinimalSampler(sampling, points, set_size, sets_rng,
                            has_quality ? Span(quality) : std::span<const double>(), Span(weights), space.threshold());
}

template <MinimalModel Model>
Estimate EstimateModel(const NormalizedProblem& space, const ClassicalOptions& options, const Rng& rng) {
  ConsensusOptions consensus = OptionsOfProblem(space, options.consensus);
  consensus.max_iterations = options.max_iterations;
  if (options.instances.Several()) {
    const auto sampler_of = [&](const std::vector<int>& rows, int search) {
      const PointRows part(space, rows);
      return SamplerOf(part.space(), Model::kMinimalSize, options, search == 0 ? rng : rng.Fork("search", search));
    };
    return EstimateOf(FindInstances<Model>(space.points(), space.threshold(), sampler_of, consensus, options.instances,
                                           rng.Fork("consensus"), PriorsOfProblem(space, consensus)));
  }
  const auto sampler = SamplerOf(space, Model::kMinimalSize, options, rng);
  ConsensusResult found =
      SearchCheckedPoints<Model>(space.points(), space.threshold(), *sampler, consensus, rng.Fork("consensus"),
                                 PriorsOfProblem(space, consensus), options.search_threads);
  if (options.photographs) PutCameraBehind(space, rng, &found);
  return EstimateOf(space, std::move(found));
}

}  // namespace

ClassicalOptions LoRansacOptions(Task task) {
  ClassicalOptions options;
  options.consensus.score = ScoreKind::kMsac;
  options.consensus.local_optimization = LocalOptimization::kInnerSamples;
  options.consensus.refit = Refit::kIterated;
  options.consensus.refit_rounds = 5;
  options.consensus.refit_threshold_factor = 1.2;
  options.consensus.final_score = ScoreKind::kMsac;
  if (DispatchTask(task, []<MinimalModel Model>() { return HasRefine<Model>; }))
    options.consensus.final_refinement = FinalRefinement::kRefinement;
  return options;
}

ClassicalEstimator::ClassicalEstimator(const ClassicalOptions& options) : options_(options) {
  if (options.max_iterations < 1) throw Error("max_iterations: expected at least 1");
  options.consensus.Check();
  LoadChooser(&options_.instances);
}

Estimate ClassicalEstimator::DoRun(const NormalizedProblem& space, std::uint64_t seed) const {
  return TimedEstimate(space, [&]<MinimalModel Model>(const NormalizedProblem& of_points) {
    return EstimateModel<Model>(of_points, options_, Rng(seed));
  });
}

}  // namespace diffsac
