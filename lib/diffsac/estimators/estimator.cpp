#include "diffsac/estimators/estimator.h"

#include <algorithm>
#include <tuple>

#include "diffsac/core/embedded_models.h"
#include "diffsac/core/lru_cache.h"
#include "diffsac/estimators/classical.h"
#include "diffsac/estimators/diffsac_estimator.h"
#include "diffsac/estimators/diffsac_model.h"
#include "diffsac/estimators/mirror_check.h"
#include "diffsac/estimators/pixel_length.h"
#include "diffsac/estimators/presets.h"
#include "diffsac/estimators/require.h"
#include "diffsac/estimators/score_check.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

constexpr int kMostKept = 32;

/// Estimators of other options share it.
std::shared_ptr<const DiffsacModel> NetworkOf(const std::string& file, Task task) {
  static LruCache<DiffsacModel> networks(kMostKept);
  return networks.Get(
      file, [&] { return LoadDiffsac(ReadTrainedConfig(file, "diffsac", task), NetworkEngine::kAuto, "cpu"); });
}

bool HasNetwork(Task task, Guidance guidance) {
  if (guidance == Guidance::kNone) return false;
  if (guidance == Guidance::kDiffusion && (task == Task::kLine || task == Task::kPlane)) return true;
  return task == Task::kFundamental || task == Task::kEssential || task == Task::kHomography;
}

/// The ε for which a preset's least scale, and its greatest, would be right.
struct ScalesFor {
  double least, greatest;
};

/// Noise is looked for between scales that go with ε. One that was asked for may be far from what noise can be, which
/// the size of the data tells: then the range is wider, and ε only caps the mask. Scales that begin above the noise
/// cost accuracy (docs/two_view.md), so that a greater ε does not move where they begin beyond the usual.
ScalesFor ScalesOfProblem(const Problem& problem, bool asked) {
  constexpr double kLeastShare = 0.2;
  const double threshold = problem.inlier_threshold;
  if (!asked || !IsTwoView(problem.task)) return {threshold, threshold};
  const double usual = UsualThreshold(problem.task) * LengthInResiduals(problem.task, problem.points.leftCols(2),
                                                                        problem.points.rightCols(2), ShareOfExtent);
  if (!(usual > 0.0)) return {threshold, threshold};
  return {std::min(threshold, usual), std::max(threshold, kLeastShare * usual)};
}

}  // namespace

Estimator::Estimator(Task task, const EstimateOptions& options, bool several)
    : task_(task), options_(options), several_(several) {
  options.Check();
  Require(options.guidance != Guidance::kDiffusion || (!several && HasNetwork(task, options.guidance)), "guidance",
          "none or network: diffusion has no network for " + std::string(several ? "several models" : ToString(task)));
}

std::shared_ptr<const RobustEstimator> Estimator::Make(Known known) const {
  Require(options_.guidance != Guidance::kDiffusion || known != kScores, "guidance",
          "none or network for matches with scores: diffusion's networks know ratios, or neither");
  if (several_ || !HasNetwork(task_, options_.guidance) || known == kScores) {
    ClassicalOptions preset = several_ ? SeveralStructures(task_) : RecommendedClassical(task_);
    Apply(options_, &preset);
    return std::make_shared<ClassicalEstimator>(preset);
  }
  DiffsacOptions preset = options_.guidance == Guidance::kDiffusion ? DiffusionGuided(task_) : LearnedProsac(task_);
  Apply(options_, &preset);
  const auto network = NetworkOf(ModelPlace(ModelFile(task_, known == kRatios), options_.models_folder), task_);
  return std::make_shared<DiffsacEstimator>(network, preset, 1);
}

const RobustEstimator& Estimator::For(Known known) const {
  const std::lock_guard lock(mutex_);
  auto& made = made_[known];
  if (made == nullptr) made = Make(known);
  return *made;
}

const RobustEstimator& Estimator::For(const Problem& problem) const {
  if (problem.match_ratio.size() > 0) return For(problem.scored ? kScores : kRatios);
  if (!problem.scored) return For(kNothing);
  try {
    return For(kNothing);
  } catch (const Error&) {
    return For(kScores);  // Which needs no network: there may be none.
  }
}

Estimate Estimator::Run(const Problem& problem, std::uint64_t seed, bool threshold_asked) const {
  Require(problem.task == task_, "problem.task", ToString(task_) + ", got " + ToString(problem.task));
  if (several_) return For(problem).Run(problem, seed);
  const auto search = [&](const Problem& given) { return Search(given, seed, threshold_asked); };
  Estimate estimate = SearchCheckingScores(problem, search);
  CheckMirrored(problem, search, &estimate);
  return estimate;
}

/// Noise that turns out to be far above where a wide range begins is estimated from once more, with scales about it.
Estimate Estimator::Search(const Problem& problem, std::uint64_t seed, bool threshold_asked) const {
  constexpr double kFar = 2.0, kSuited = 1.5;  // The middle of the presets' ranges is about ε / 1.5.
  const RobustEstimator& estimator = For(problem);
  Problem scaled = problem;
  const auto run = [&](const ScalesFor& scales) {
    scaled.least_scale_factor = scales.least / UsualThreshold(task_);
    scaled.greatest_scale_factor = scales.greatest / UsualThreshold(task_);
    return estimator.Run(scaled, seed);
  };
  const ScalesFor scales = ScalesOfProblem(problem, threshold_asked);
  Estimate estimate = run(scales);
  if (estimate.status != Status::kOk || !(scales.least < scales.greatest) ||
      !(estimate.noise_scale > kFar * scales.least))
    return estimate;
  const double suited = kSuited * estimate.noise_scale;
  Estimate again = run({suited, suited});
  if (again.status != Status::kOk) return estimate;
  AddCost(estimate.report, &again.report);
  return again;
}

std::shared_ptr<const Estimator> KeptEstimator(Task task, const EstimateOptions& options, bool several) {
  using Key = std::tuple<Task, EstimateOptions, bool>;
  static LruCache<Estimator, Key> kept(kMostKept);
  EstimateOptions made_from = options;
  made_from.seed = 0;
  return kept.Get({task, made_from, several},
                  [&] { return std::make_shared<const Estimator>(task, options, several); });
}

}  // namespace diffsac
