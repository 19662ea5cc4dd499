#include "diffsac/methods/classical.h"

#include <span>
#include <utility>

#include "diffsac/consensus/model_hooks.h"
#include "diffsac/methods/known_of_problem.h"
#include "diffsac/methods/method_registry.h"
#include "diffsac/methods/point_rows.h"
#include "diffsac/methods/task_dispatch.h"

namespace diffsac {
namespace {

std::span<const double> Span(const Eigen::VectorXd& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

/// The source of one problem's sets. Every set, where the row asks for that and the budget holds them.
std::unique_ptr<HypothesisSource> SourceOf(const SolverSpace& space, int set_size, const ClassicalOptions& options,
                                           const Rng& rng) {
  const PointMatrix& points = space.points();
  const Eigen::VectorXd& quality = space.problem().quality;
  const int size = static_cast<int>(points.rows());
  if (options.exhaustive && Combinations(size, set_size) <= options.hypotheses)
    return std::make_unique<ExhaustiveSource>(size, set_size);
  const bool has_quality = quality.size() == size;
  SourceOptions sampling = options.sampling;
  if (sampling.source == SourceKind::kProsac && !has_quality) sampling.source = SourceKind::kUniform;
  // Two names, because published tables were drawn with them.
  const Rng sets_rng =
      sampling.source == SourceKind::kUniform ? rng.Fork("minimal_sets") : rng.Fork("consensus").Fork("minimal_sets");
  return MakeHypothesisSource(sampling, points, set_size, sets_rng,
                              has_quality ? Span(quality) : std::span<const double>());
}

template <MinimalModel Model>
Estimate EstimateModel(const SolverSpace& space, const ClassicalOptions& options, const Rng& rng) {
  ConsensusOptions consensus = options.consensus;
  consensus.max_iterations = options.hypotheses;
  if (options.structures.Several()) {
    const auto source_of = [&](const std::vector<int>& rows, int search) {
      const PointRows part(space, rows);
      return SourceOf(part.space(), Model::kMinimalSize, options, search == 0 ? rng : rng.Fork("search", search));
    };
    return EstimateOf(FindStructures<Model>(space.points(), space.threshold(), source_of, consensus, options.structures,
                                            rng.Fork("consensus"), KnownOf(space, consensus)));
  }
  const auto source = SourceOf(space, Model::kMinimalSize, options, rng);
  return EstimateOf(space, SearchCheckedPoints<Model>(space.points(), space.threshold(), *source, consensus,
                                                      rng.Fork("consensus"), KnownOf(space, consensus)));
}

}  // namespace

void ClassicalOptions::Bind(OptionsBinder& b) {
  b.Field("hypotheses", hypotheses, Within(1, 1e7))
      .Help("minimal sets: exactly so many, at most with stopping: confidence");
  b.Field("sampling", sampling).Help("the source of minimal sets");
  consensus.max_iterations = hypotheses;
  b.Field("consensus", consensus).Help("score, local optimisation, stopping and refits");
  b.Field("structures", structures).Help("whether several models are looked for, and how");
  b.Require(consensus.max_iterations == hypotheses, "consensus.max_iterations",
            "nothing; this row's budget is `hypotheses`");
  b.Require(consensus.min_iterations <= hypotheses, "consensus.min_iterations", "at most `hypotheses`");
}

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

Estimate ClassicalMethod::DoEstimate(const Problem& problem, std::uint64_t seed) const {
  return TimedEstimate(problem, [&]<MinimalModel Model>(const SolverSpace& space) {
    return EstimateModel<Model>(space, options_, Rng(seed));
  });
}

namespace {

struct RegisteredClassical : RegisteredMethod<ClassicalOptions> {
  RegisteredClassical(const std::string& type, const std::string& help, Defaults defaults)
      : RegisteredMethod(type, help, std::move(defaults),
                         [](const ClassicalOptions& options) { return std::make_unique<ClassicalMethod>(options); }) {}
};

/// `lo_ransac` with sets from another source.
RegisteredClassical::Defaults LoRansacFrom(SourceKind source) {
  return [source](Task task) {
    ClassicalOptions options = LoRansacOptions(task);
    options.sampling.source = source;
    return options;
  };
}

const RegisteredClassical kRansac("ransac", "Inlier count, one least squares on the inliers.",
                                  [](Task) { return ClassicalOptions(); });
const RegisteredClassical kLoRansac("lo_ransac",
                                    "MSAC, local optimisation, iterated refits (Chum, Matas, Kittler 2003).",
                                    LoRansacOptions);
const RegisteredClassical kProsac("prosac", "`lo_ransac` with sets in the order of quality (Chum, Matas 2005).",
                                  LoRansacFrom(SourceKind::kProsac));
const RegisteredClassical kNapsac("napsac", "`lo_ransac` with sets from neighbourhoods (Torr et al. 2002).",
                                  LoRansacFrom(SourceKind::kNapsac));
const RegisteredClassical kProgressiveNapsac("p_napsac",
                                             "`lo_ransac` with sets from growing neighbourhoods (Barath et al. 2020).",
                                             LoRansacFrom(SourceKind::kProgressiveNapsac));
const RegisteredClassical kGcRansac("gc_ransac", "`lo_ransac` with graph-cut local optimisation (Barath, Matas 2018).",
                                    [](Task task) {
                                      ClassicalOptions options = LoRansacOptions(task);
                                      options.consensus.local_optimization = LocalOptimization::kGraphCut;
                                      return options;
                                    });
const RegisteredClassical kMagsac("magsac_pp",
                                  "MAGSAC++ score, reweighted local optimisation and refit (Barath et al. 2020).",
                                  [](Task task) {
                                    ClassicalOptions options = LoRansacOptions(task);
                                    ConsensusOptions& consensus = options.consensus;
                                    consensus.score = consensus.final_score = ScoreKind::kMagsac;
                                    consensus.score_threshold_factor = 2.5;
                                    consensus.local_optimization = LocalOptimization::kReweighted;
                                    consensus.refit = Refit::kReweighted;
                                    consensus.refit_threshold_factor = 1.0;
                                    return options;
                                  });
const RegisteredClassical kExhaustive(
    "exhaustive", "Lines and planes: every minimal set, the best 5 refitted by expectation maximisation.",
    [](Task task) {
      if (IsTwoView(task)) throw Error("exhaustive searches lines and planes only; too many minimal sets");
      ClassicalOptions options = LoRansacOptions(task);
      options.exhaustive = true;
      options.hypotheses = 2'000'000;
      ConsensusOptions& consensus = options.consensus;
      consensus.local_optimization = LocalOptimization::kNone;
      consensus.refit = Refit::kMixture;
      consensus.refit_rounds = 1;
      consensus.refit_threshold_factor = 1.0;
      consensus.refit_candidates = 5;
      consensus.final_score = ScoreKind::kGaussianUniform;
      return options;
    });

}  // namespace

}  // namespace diffsac
