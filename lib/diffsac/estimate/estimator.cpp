#include "diffsac/estimate/estimator.h"

#include <algorithm>
#include <tuple>

#include "diffsac/core/embedded_models.h"
#include "diffsac/core/lru_cache.h"
#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/diffsac_estimator.h"
#include "diffsac/estimate/diffsac_model.h"
#include "diffsac/estimate/presets.h"
#include "diffsac/estimate/require.h"
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
    ClassicalOptions preset = several_ ? SeveralInstances(task_) : RecommendedClassical(task_);
    Apply(options_, &preset);
    return Made(std::make_shared<ClassicalEstimator>(preset), known);
  }
  DiffsacOptions preset = options_.guidance == Guidance::kDiffusion ? DiffusionGuided(task_) : LearnedProsac(task_);
  Apply(options_, &preset);
  const auto network = NetworkOf(ModelPlace(ModelFile(task_, known == kRatios), options_.models_folder), task_);
  return Made(std::make_shared<DiffsacEstimator>(network, preset, 1), known);
}

std::shared_ptr<const RobustEstimator> Estimator::Made(std::shared_ptr<RobustEstimator> made, Known known) const {
  if (known != kNothing) made->SetWithoutScores([this]() -> const RobustEstimator& { return WithoutScores(); });
  return made;
}

const RobustEstimator& Estimator::For(Known known) const {
  const std::lock_guard lock(mutex_);
  auto& made = made_[known];
  if (made == nullptr) made = Make(known);
  return *made;
}

const RobustEstimator& Estimator::For(const Problem& problem) const {
  if (problem.snn_ratio.size() > 0) return For(problem.scored ? kScores : kRatios);
  return problem.scored ? WithoutScores() : For(kNothing);
}

const RobustEstimator& Estimator::WithoutScores() const {
  try {
    return For(kNothing);
  } catch (const Error&) {
    return For(kScores);  // Which needs no network: there may be none.
  }
}

Estimate Estimator::Run(const Problem& problem, std::uint64_t seed) const {
  Require(problem.task == task_, "problem.task", ToString(task_) + ", got " + ToString(problem.task));
  return For(problem).Run(problem, seed);
}

std::shared_ptr<const Estimator> CachedEstimator(Task task, const EstimateOptions& options, bool several) {
  using Key = std::tuple<Task, EstimateOptions, bool>;
  static LruCache<Estimator, Key> kept(kMostKept);
  EstimateOptions made_from = options;
  made_from.seed = 0;
  return kept.Get({task, made_from, several},
                  [&] { return std::make_shared<const Estimator>(task, options, several); });
}

}  // namespace diffsac
