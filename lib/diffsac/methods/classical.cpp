#include "diffsac/methods/classical.h"

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>

#include "diffsac/methods/line_posterior.h"
#include "diffsac/methods/task_dispatch.h"
#include "diffsac/methods/theil_sen.h"

namespace diffsac {
namespace {

constexpr const char* kTypes[] = {"ransac",   "lo_ransac", "prosac",    "napsac",
                                  "p_napsac", "gc_ransac", "magsac_pp", "exhaustive"};

bool IsClassical(const std::string& type) { return std::find(std::begin(kTypes), std::end(kTypes), type) != std::end(kTypes); }

std::span<const double> Span(const Eigen::VectorXd& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

/// Uniform and exhaustive searches of a fixed budget draw all their sets at once.
template <MinimalModel Model>
ConsensusResult Search(const Problem& problem, const SolverSpace& space, const ClassicalOptions& options, const Rng& rng) {
  const int num_points = static_cast<int>(space.points().rows());
  const Rng consensus_rng = rng.Fork("consensus");
  const bool all = options.exhaustive && Combinations(num_points, Model::kMinimalSize) <= options.hypotheses;
  SourceOptions sampling = options.sampling;
  if (sampling.source == "prosac" && problem.quality.size() != num_points) sampling.source = "uniform";
  if (all || (sampling.source == "uniform" && options.consensus.stopping == "budget")) {
    std::vector<int> sets;
    if (all)
      ExhaustiveSource().Draw(num_points, Model::kMinimalSize, 0, rng, &sets);
    else
      UniformSource().Draw(num_points, Model::kMinimalSize, options.hypotheses, rng.Fork("minimal_sets"), &sets);
    return SampleConsensus<Model>(space.points(), space.threshold(), sets, options.consensus, consensus_rng);
  }
  const bool has_quality = problem.quality.size() == num_points;
  const auto source = MakeHypothesisSource(sampling, space.points(), Model::kMinimalSize,
                                           has_quality ? Span(problem.quality) : std::span<const double>());
  ConsensusOptions consensus = options.consensus;
  consensus.max_iterations = options.hypotheses;
  consensus.min_iterations = std::min(consensus.min_iterations, options.hypotheses);
  return SampleConsensus<Model>(space.points(), space.threshold(), *source, consensus, consensus_rng);
}

template <MinimalModel Model>
Estimate EstimateModel(const Problem& problem, const ClassicalOptions& options, std::uint64_t seed) {
  Estimate estimate;
  estimate.status = CheckProblem(problem);
  if (estimate.status != Status::kOk) return estimate;
  const SolverSpace space(problem);
  return EstimateOf(Search<Model>(problem, space, options, Rng(seed)));
}

/// MSAC, local optimisation and refits: what every searching row but `ransac` starts from.
ClassicalOptions LocallyOptimized(Task task) {
  ClassicalOptions options;
  options.consensus.score = "msac";
  options.consensus.local_optimization = "lo_ransac";
  options.consensus.refit = "iterated";
  options.consensus.refit_rounds = 5;
  options.consensus.refit_threshold_factor = 1.2;
  options.consensus.final_score = "msac";
  if (IsTwoView(task)) options.consensus.final_refinement = "lm";
  return options;
}

}  // namespace

void ClassicalOptions::Bind(OptionsBinder& b) {
  b.Field("hypotheses", hypotheses, AtLeast(1));
  b.Group("sampling", sampling);
  b.Group("consensus", consensus);
  for (const char* key : {"name", "type", "label", "paper", "conditions"}) b.Ignore(key);
}

ClassicalOptions DefaultClassicalOptions(const std::string& type, Task task) {
  if (!IsClassical(type)) throw Error("unknown method type '" + type + "'");
  if (type == "ransac") return {};
  ClassicalOptions options = LocallyOptimized(task);
  if (type == "prosac" || type == "napsac" || type == "p_napsac") options.sampling.source = type;
  if (type == "gc_ransac") options.consensus.local_optimization = "gc_ransac";
  if (type == "magsac_pp") {
    options.consensus.score = options.consensus.final_score = "magsac_pp";
    options.consensus.score_threshold_factor = 2.5;
    options.consensus.local_optimization = options.consensus.refit = "irls";
    options.consensus.refit_threshold_factor = 1.0;
  }
  if (type == "exhaustive") {
    options.exhaustive = true;
    options.hypotheses = 2'000'000;
    options.consensus.local_optimization = "none";
    options.consensus.refit = "em";
    options.consensus.refit_rounds = 1;
    options.consensus.refit_threshold_factor = 1.0;
    options.consensus.refit_candidates = 5;
    options.consensus.final_score = "gaussian_uniform";
  }
  return options;
}

Estimate ClassicalMethod::Estimate(const Problem& problem, std::uint64_t seed) const {
  return TimedEstimate(problem.task, [&]<MinimalModel Model>() { return EstimateModel<Model>(problem, options_, seed); });
}

std::unique_ptr<Method> MakeClassicalMethod(const std::string& type, const Config& config, Task task) {
  if (type == "theil_sen") {
    if (IsTwoView(task)) throw Error(config.Where("type") + ": theil_sen estimates lines and planes only");
    return std::make_unique<TheilSenMethod>(ReadOptions<TheilSenOptions>(config));
  }
  if (type == "line_posterior") {
    if (task != Task::kLine) throw Error(config.Where("type") + ": line_posterior estimates lines only");
    return std::make_unique<LinePosteriorMethod>(ReadOptions<LinePosteriorOptions>(config));
  }
  if (!IsClassical(type)) return nullptr;
  if (type == "exhaustive" && IsTwoView(task))
    throw Error(config.Where("type") + ": exhaustive searches lines and planes only; too many minimal sets");
  return std::make_unique<ClassicalMethod>(ReadOptions<ClassicalOptions>(config, DefaultClassicalOptions(type, task)));
}

}  // namespace diffsac
