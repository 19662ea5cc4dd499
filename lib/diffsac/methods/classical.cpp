#include "diffsac/methods/classical.h"

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>

#include "diffsac/consensus/model_hooks.h"
#include "diffsac/methods/line_posterior.h"
#include "diffsac/methods/task_dispatch.h"
#include "diffsac/methods/theil_sen.h"

namespace diffsac {
namespace {

constexpr const char* kTypes[] = {"ransac",   "lo_ransac", "prosac",    "napsac",
                                  "p_napsac", "gc_ransac", "magsac_pp", "exhaustive"};

bool IsClassical(const std::string& type) {
  return std::find(std::begin(kTypes), std::end(kTypes), type) != std::end(kTypes);
}

std::span<const double> Span(const Eigen::VectorXd& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

/// The source of one problem's sets. Every set, where the row asks for that and the budget holds them.
std::unique_ptr<HypothesisSource> SourceOf(const Problem& problem, const PointMatrix& points, int set_size,
                                           const ClassicalOptions& options, const Rng& rng) {
  const int size = static_cast<int>(points.rows());
  if (options.exhaustive && Combinations(size, set_size) <= options.hypotheses)
    return std::make_unique<ExhaustiveSource>(size, set_size);
  const bool has_quality = problem.quality.size() == size;
  SourceOptions sampling = options.sampling;
  if (sampling.source == SourceKind::kProsac && !has_quality) sampling.source = SourceKind::kUniform;
  // Two names, because published tables were drawn with them.
  const Rng sets_rng =
      sampling.source == SourceKind::kUniform ? rng.Fork("minimal_sets") : rng.Fork("consensus").Fork("minimal_sets");
  return MakeHypothesisSource(sampling, points, set_size, sets_rng,
                              has_quality ? Span(problem.quality) : std::span<const double>());
}

template <MinimalModel Model>
ConsensusResult Search(const Problem& problem, const SolverSpace& space, const ClassicalOptions& options,
                       const Rng& rng) {
  const auto source = SourceOf(problem, space.points(), Model::kMinimalSize, options, rng);
  ConsensusOptions consensus = options.consensus;
  consensus.max_iterations = options.hypotheses;
  return SampleConsensus<Model>(space.points(), space.threshold(), *source, consensus, rng.Fork("consensus"));
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

}  // namespace

void ClassicalOptions::Bind(OptionsBinder& b) {
  b.Field("hypotheses", hypotheses, AtLeast(1))
      .Help("minimal sets: exactly so many, at most with stopping: confidence");
  b.Field("sampling", sampling).Help("the source of minimal sets");
  consensus.max_iterations = hypotheses;
  b.Field("consensus", consensus).Help("score, local optimisation, stopping and refits");
  b.Require(consensus.max_iterations == hypotheses, "consensus.max_iterations",
            "nothing; this row's budget is `hypotheses`");
  b.Require(consensus.min_iterations <= hypotheses, "consensus.min_iterations", "at most `hypotheses`");
  for (const char* key : {"name", "type", "label", "paper", "conditions"}) b.Ignore(key);
}

ClassicalOptions DefaultClassicalOptions(const std::string& type, Task task) {
  if (!IsClassical(type)) throw Error("unknown method type '" + type + "'");
  if (type == "ransac") return {};
  ClassicalOptions options = LocallyOptimized(task);
  if (type == "prosac" || type == "napsac" || type == "p_napsac")
    options.sampling.source = FromString<SourceKind>(type);
  if (type == "gc_ransac") options.consensus.local_optimization = LocalOptimization::kGraphCut;
  if (type == "magsac_pp") {
    options.consensus.score = options.consensus.final_score = ScoreKind::kMagsac;
    options.consensus.score_threshold_factor = 2.5;
    options.consensus.local_optimization = LocalOptimization::kReweighted;
    options.consensus.refit = Refit::kReweighted;
    options.consensus.refit_threshold_factor = 1.0;
  }
  if (type == "exhaustive") {
    options.exhaustive = true;
    options.hypotheses = 2'000'000;
    options.consensus.local_optimization = LocalOptimization::kNone;
    options.consensus.refit = Refit::kMixture;
    options.consensus.refit_rounds = 1;
    options.consensus.refit_threshold_factor = 1.0;
    options.consensus.refit_candidates = 5;
    options.consensus.final_score = ScoreKind::kGaussianUniform;
  }
  return options;
}

Estimate ClassicalMethod::Estimate(const Problem& problem, std::uint64_t seed) const {
  return TimedEstimate(problem.task,
                       [&]<MinimalModel Model>() { return EstimateModel<Model>(problem, options_, seed); });
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
