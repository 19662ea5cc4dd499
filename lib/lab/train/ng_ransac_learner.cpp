#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "diffsac/core/parallel.h"
#include "diffsac/estimate/task_dispatch.h"
#include "lab/eval/metrics.h"
#include "lab/ground_truth/labels.h"
#include "lab/options/options.h"
#include "lab/torch/ng_ransac.h"
#include "lab/train/batch_tensors.h"
#include "lab/train/expected_loss.h"
#include "lab/train/metrics_log.h"
#include "lab/train/network_learner.h"

namespace diffsac {

namespace {

/// The target of the initialisation falls with exp(−r² / 2σ²): σ in multiples of ε.
constexpr double kTargetSigma = 1.0;
/// An error counts at most so many validation thresholds, as 1.
constexpr double kLossCap = 4.0;

/// The group `ng_ransac` of a training configuration: Brachmann and Rother, "Neural-guided RANSAC", ICCV 2019.
struct NgRansacPhases {
  int initialization_iterations = 2500;
  double rate_factor = 0.1;
  int pools = 4;
  int hypotheses = 16;
  static constexpr const char* kHelp = "NG-RANSAC's two phases (docs/ng_ransac.md)";
  void Bind(OptionsBinder& b) {
    b.Field("initialization_iterations", initialization_iterations, AtLeast(0))
        .Help(
            "the first steps train towards a target distribution made of residuals to the true model, the others "
            "minimise the expected task loss");
    b.Field("rate_factor", rate_factor, Positive()).Help("of the learning rate after the initialisation");
    b.Field("pools", pools, Within(2, 1000))
        .Help("draws of a pool of hypotheses for each problem; their mean loss is the baseline");
    b.Field("hypotheses", hypotheses, Within(1, 100000)).Help("minimal sets in a pool");
  }
};

template <MinimalModel Model>
Estimate Select(const Problem& problem, std::vector<int> sets, const ConsensusOptions& options, const Rng& rng) {
  for (auto set = sets.begin(); set != sets.end(); set += Model::kMinimalSize)
    std::sort(set, set + Model::kMinimalSize);
  const NormalizedProblem space(problem);
  PrecomputedSampler source(sets);
  return EstimateOf(space, SampleConsensus<Model>(space.points(), space.threshold(), source, options, rng));
}

class NgRansacLearner : public NetworkLearner<WeightedEstimator, WeightTraining<NgRansacNetwork, NgRansacPhases>> {
 public:
  using NetworkLearner::NetworkLearner;
  std::vector<std::string> loss_names() const override { return {"loss_target", "loss_expected"}; }
  double RateFactor(std::int64_t iteration) const override {
    return IsInitialization(iteration) ? 1.0 : own_.learning.rate_factor;
  }
  Loss Compute(const std::vector<TrainingItem>& items, std::int64_t iteration,
               const std::vector<double>& shares) override;

 private:
  Loss ExpectedLoss(const std::vector<TrainingItem>& items, const torch::Tensor& log_weights, double target) const;
  bool IsInitialization(std::int64_t iteration) const { return iteration < own_.learning.initialization_iterations; }
  TaskModel UsedModel() const { return ModelFromString(task_, own_.inference.model); }
  double PoolLoss(const Example& example, std::vector<int> sets, const Rng& rng) const;
};

// ℓ of the hypothesis that the consensus of `inference` selects from a pool and refines, in [0, 1]: the error of the
// task's tables.
double NgRansacLearner::PoolLoss(const Example& example, std::vector<int> sets, const Rng& rng) const {
  auto consensus = own_.inference.consensus;
  consensus.stopping = Stopping::kBudget;
  consensus.max_iterations = own_.learning.hypotheses;
  const auto& problem = example.problem;
  const auto estimate = DispatchModel(
      UsedModel(), [&]<class Model>() { return Select<Model>(problem, std::move(sets), consensus, rng); });
  const Tolerance tolerance = options_.validation.ToleranceOf(task_);
  double error = MainError(MeasureError(estimate, example), tolerance);
  // Of several structures that which the hypothesis is of: any is right.
  for (std::size_t k = 0; k < example.truth.instances.size(); ++k) {
    const double of_one = MainError(MeasureError(estimate, OfInstance(example, k)), tolerance);
    error = k == 0 ? of_one : std::min(error, of_one);
  }
  return std::isnan(error) ? 1.0 : std::min(1.0, error / (kLossCap * tolerance.value));
}

Learner::Loss NgRansacLearner::ExpectedLoss(const std::vector<TrainingItem>& items, const torch::Tensor& log_weights,
                                            double target) const {
  const auto& train = own_.learning;
  const std::int64_t batch = static_cast<std::int64_t>(items.size()), pools = train.pools, sets = train.hypotheses;
  const std::int64_t set_size = MinimalSetSize(UsedModel()), pool_size = sets * set_size;
  const auto weights = log_weights.detach().to(torch::kCPU).contiguous();
  auto chosen = torch::zeros({batch, pools * sets, set_size}, torch::kLong);
  auto losses = torch::zeros({batch, pools});
  const Rng draws(options_.train.seed);
  ParallelFor(batch, threads_, [&](std::int64_t b) {
    const auto& example = *items[b].example;
    const auto length = static_cast<std::size_t>(example.problem.points.rows());
    const std::span<const float> own(weights.data_ptr<float>() + b * weights.size(1), length);
    const Rng rng = draws.Fork("ng_ransac", items[b].index);
    const auto drawn =
        DrawOrderedSets(own, static_cast<int>(set_size), static_cast<int>(pools * sets), rng.Fork("minimal_sets"));
    std::copy(drawn.begin(), drawn.end(), chosen.data_ptr<std::int64_t>() + b * pools * pool_size);
    for (std::int64_t k = 0; k < pools; ++k) {
      const auto first = drawn.begin() + k * pool_size;
      losses.data_ptr<float>()[b * pools + k] =
          static_cast<float>(PoolLoss(example, {first, first + pool_size}, rng.Fork("consensus")));
    }
  });
  const auto log_probability =
      OrderedSetLogProbability(log_weights, chosen.to(device_)).view({batch, pools, sets}).sum(-1);
  return {ExpectedLossSurrogate(log_probability, losses.to(device_)), {target, losses.mean().item<double>()}};
}

Learner::Loss NgRansacLearner::Compute(const std::vector<TrainingItem>& items, std::int64_t iteration,
                                       const std::vector<double>& shares) {
  const auto points = CollatePoints(items);
  const auto log_weights = dynamic_cast<NgRansacNetwork&>(*network_->module).LogWeights(points.To(device_));
  std::vector<std::vector<float>> targets;
  for (const auto& item : items) targets.push_back(TargetDistribution(*item.example, kTargetSigma));
  const auto divergence = TargetDivergence(log_weights, PadRows(targets, points.max_points(), 0.0f).to(device_));
  auto loss = IsInitialization(iteration) ? Loss{divergence, {divergence.item<double>(), kNotMeasured}}
                                          : ExpectedLoss(items, log_weights, divergence.item<double>());
  loss.total = shares[0] * loss.total;
  return loss;
}

const RegisteredLearner<NgRansacLearner::Training, NgRansacLearner> kNgRansac(
    "ng_ransac", "Weights of points from which minimal sets are drawn (Brachmann and Rother, ICCV 2019).");

}  // namespace
}  // namespace diffsac
