#include "diffsac/estimators/estimator.h"

#include <algorithm>
#include <tuple>

#include "diffsac/core/lru_cache.h"
#include "diffsac/core/resources.h"
#include "diffsac/estimators/classical.h"
#include "diffsac/estimators/diffsac_estimator.h"
#include "diffsac/estimators/diffsac_model.h"
#include "diffsac/estimators/presets.h"
#include "diffsac/estimators/require.h"
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

/// The halves of a budget that the head and PROSAC draw.
DiffsacOptions LearnedOptionsOf(Task task, const EstimateOptions& options) {
  DiffsacOptions learned = LearnedProsac(task);
  learned.photographs = options.cameras == Cameras::kPhotographs;
  if (options.max_iterations == 0) return learned;
  learned.head_sets = (options.max_iterations + 1) / 2;
  learned.extra_sets = options.max_iterations / 2;
  learned.consensus.max_iterations = options.max_iterations;
  learned.consensus.min_iterations = std::min(learned.consensus.min_iterations, options.max_iterations);
  return learned;
}

ClassicalOptions WithOptions(ClassicalOptions classical, const EstimateOptions& options) {
  classical.photographs = classical.photographs && options.cameras == Cameras::kPhotographs;
  if (options.max_iterations == 0) return classical;
  classical.max_iterations = options.max_iterations;
  ConsensusOptions& consensus = classical.consensus;
  consensus.min_iterations = std::min(consensus.min_iterations, options.max_iterations);
  return classical;
}

bool HasNetwork(Task task) {
  return task == Task::kFundamental || task == Task::kEssential || task == Task::kHomography;
}

}  // namespace

void EstimateOptions::Check() const {
  Require(max_iterations >= 0 && max_iterations <= kMostIterations, "max_iterations",
          "from 0 to " + std::to_string(kMostIterations));
}

Estimator::Estimator(Task task, const EstimateOptions& options, bool several)
    : task_(task), options_(options), several_(several) {
  options.Check();
}

std::shared_ptr<const RobustEstimator> Estimator::Make(Known known) const {
  if (several_) return std::make_shared<ClassicalEstimator>(WithOptions(SeveralStructures(task_), options_));
  if (!HasNetwork(task_) || !options_.use_network || known == kScores)
    return std::make_shared<ClassicalEstimator>(WithOptions(RecommendedClassical(task_), options_));
  const auto network = NetworkOf(FindModel(ModelFile(task_, known == kRatios), options_.models_folder), task_);
  return std::make_shared<DiffsacEstimator>(network, LearnedOptionsOf(task_, options_), 1);
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

Estimate Estimator::Run(const Problem& problem, std::uint64_t seed) const {
  Require(problem.task == task_, "problem.task", ToString(task_) + ", got " + ToString(problem.task));
  return For(problem).Run(problem, seed);
}

std::shared_ptr<const Estimator> KeptEstimator(Task task, const EstimateOptions& options, bool several) {
  using Key = std::tuple<Task, bool, int, bool, Cameras, std::string>;
  static LruCache<Estimator, Key> kept(kMostKept);
  return kept.Get({task, several, options.max_iterations, options.use_network, options.cameras, options.models_folder},
                  [&] { return std::make_shared<const Estimator>(task, options, several); });
}

}  // namespace diffsac
