#include "diffsac/methods/classical.h"

#include <utility>

#include "diffsac/methods/line_posterior.h"
#include "diffsac/methods/task_dispatch.h"
#include "diffsac/methods/theil_sen.h"

namespace diffsac {
namespace {

template <MinimalModel Model>
Estimate EstimateModel(const Problem& problem, const ClassicalOptions& options, std::uint64_t seed) {
  Estimate estimate;
  estimate.status = CheckPoints<Model>(problem.points);
  if (estimate.status != Status::kOk) return estimate;
  const Rng rng(seed);
  const int num_points = static_cast<int>(problem.points.rows());
  std::vector<int> sets;
  if (options.exhaustive && Combinations(num_points, Model::kMinimalSize) <= options.hypotheses) {
    ExhaustiveSource().Draw(num_points, Model::kMinimalSize, 0, rng, &sets);
  } else {
    UniformSource().Draw(num_points, Model::kMinimalSize, options.hypotheses, rng.Fork("minimal_sets"), &sets);
  }
  ConsensusResult result =
      SampleConsensus<Model>(problem.points, problem.inlier_threshold, sets, options.consensus, rng.Fork("consensus"));
  estimate.status = result.status;
  estimate.model = std::move(result.model);
  estimate.inliers = std::move(result.inliers);
  estimate.score = result.score;
  estimate.report.hypotheses = result.hypotheses;
  estimate.report.unique_minimal_sets = result.unique_minimal_sets;
  return estimate;
}

}  // namespace

void ClassicalOptions::Bind(OptionsBinder& b) {
  b.Field("hypotheses", hypotheses, AtLeast(1));
  b.Group("consensus", consensus);
  for (const char* key : {"name", "type", "label", "paper", "conditions"}) b.Ignore(key);
}

ClassicalOptions DefaultClassicalOptions(const std::string& type) {
  ClassicalOptions options;
  if (type == "ransac") return options;
  options.consensus.score = "msac";
  if (type == "lo_ransac") {
    options.consensus.local_optimization = "lo_ransac";
    options.consensus.refit = "iterated";
    options.consensus.refit_rounds = 5;
    options.consensus.refit_threshold_factor = 1.2;
    options.consensus.final_score = "msac";
    return options;
  }
  if (type != "exhaustive") throw Error("unknown method type '" + type + "': expected ransac, lo_ransac or exhaustive");
  options.exhaustive = true;
  options.hypotheses = 2'000'000;
  options.consensus.refit = "em";
  options.consensus.refit_candidates = 5;
  options.consensus.final_score = "gaussian_uniform";
  return options;
}

Estimate ClassicalMethod::Estimate(const Problem& problem, std::uint64_t seed) const {
  return TimedEstimate(problem.task, [&]<MinimalModel Model>() { return EstimateModel<Model>(problem, options_, seed); });
}

std::unique_ptr<Method> MakeClassicalMethod(const std::string& type, const Config& config, Task task) {
  if (type == "theil_sen") return std::make_unique<TheilSenMethod>(ReadOptions<TheilSenOptions>(config));
  if (type == "line_posterior") {
    if (task != Task::kLine) throw Error(config.Where("type") + ": line_posterior estimates lines only");
    return std::make_unique<LinePosteriorMethod>(ReadOptions<LinePosteriorOptions>(config));
  }
  if (type != "ransac" && type != "lo_ransac" && type != "exhaustive") return nullptr;
  return std::make_unique<ClassicalMethod>(ReadOptions<ClassicalOptions>(config, DefaultClassicalOptions(type)));
}

}  // namespace diffsac
