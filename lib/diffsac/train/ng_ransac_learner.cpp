#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "diffsac/core/parallel.h"
#include "diffsac/eval/metrics.h"
#include "diffsac/methods/ng_ransac.h"
#include "diffsac/methods/task_dispatch.h"
#include "diffsac/methods/weighted_method.h"
#include "diffsac/train/batch_tensors.h"
#include "diffsac/train/expected_loss.h"
#include "diffsac/train/metrics_log.h"
#include "diffsac/train/network_learner.h"

namespace diffsac {
namespace {

template <MinimalModel Model>
Estimate Select(const Problem& problem, std::vector<int> sets, const ConsensusOptions& options, const Rng& rng) {
  for (auto set = sets.begin(); set != sets.end(); set += Model::kMinimalSize)
    std::sort(set, set + Model::kMinimalSize);
  const SolverSpace space(problem);
  GivenSource source(sets);
  return EstimateOf(SampleConsensus<Model>(space.points(), space.threshold(), source, options, rng));
}

class NgRansacLearner : public NetworkLearner<LearnedWeights, WeightedMethod, WeightedMethodOptions> {
 public:
  NgRansacLearner(const TrainConfig& options, const torch::Device& device, int threads)
      : NetworkLearner(options, options.weighted_inference, device, threads, [&](Task task, const Rng& rng) {
          return MakeLearnedWeights<NgRansacNetwork>(task, options.ng_ransac_network, rng);
        }) {}
  std::vector<std::string> loss_names() const override { return {"loss_target", "loss_expected"}; }
  double RateFactor(std::int64_t iteration) const override {
    return IsInitialization(iteration) ? 1.0 : options_.ng_ransac.rate_factor;
  }
  Loss Compute(const std::vector<TrainingItem>& items, std::int64_t iteration,
               const std::vector<double>& shares) override;

 private:
  Loss ExpectedLoss(const std::vector<TrainingItem>& items, const torch::Tensor& log_weights, double target) const;
  bool IsInitialization(std::int64_t iteration) const {
    return iteration < options_.ng_ransac.initialization_iterations;
  }
  TaskModel UsedModel() const { return ModelFromString(task_, inference_.model); }
  double PoolLoss(const Example& example, std::vector<int> sets, const Rng& rng) const;
};

// ℓ of the hypothesis that the consensus selects from a pool, in [0, 1] (of "inliers": in [−1, 0]).
double NgRansacLearner::PoolLoss(const Example& example, std::vector<int> sets, const Rng& rng) const {
  auto consensus = inference_.consensus;
  consensus.stopping = Stopping::kBudget;
  consensus.max_iterations = options_.ng_ransac.hypotheses;
  const auto& problem = example.problem;
  const auto estimate = DispatchModel(UsedModel(), [&]<class Model>() {
    return Select<Model>(problem, std::move(sets), consensus, rng);
  });
  if (options_.ng_ransac.loss == "inliers")
    return -static_cast<double>(std::count(estimate.inliers.begin(), estimate.inliers.end(), 1)) /
           static_cast<double>(problem.points.rows());
  const Tolerance tolerance = options_.validation.ToleranceOf(task_);
  const double error = MainError(MeasureError(estimate, example), tolerance);
  return std::isnan(error) ? 1.0 : std::min(1.0, error / (options_.ng_ransac.loss_cap * tolerance.value));
}

Learner::Loss NgRansacLearner::ExpectedLoss(const std::vector<TrainingItem>& items, const torch::Tensor& log_weights,
                                            double target) const {
  const auto& train = options_.ng_ransac;
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
  const auto log_weights = dynamic_cast<NgRansacNetwork&>(*network_->network).LogWeights(points.To(device_));
  std::vector<std::vector<float>> targets;
  for (const auto& item : items) targets.push_back(TargetDistribution(*item.example, options_.ng_ransac.target_sigma));
  const auto divergence = TargetDivergence(log_weights, PadRows(targets, points.max_points(), 0.0f).to(device_));
  auto loss = IsInitialization(iteration) ? Loss{divergence, {divergence.item<double>(), kNotMeasured}}
                                          : ExpectedLoss(items, log_weights, divergence.item<double>());
  loss.total = shares[0] * loss.total;
  return loss;
}

}  // namespace

std::unique_ptr<Learner> MakeNgRansacLearner(const TrainConfig& options, const torch::Device& device, int threads) {
  return std::make_unique<NgRansacLearner>(options, device, threads);
}

}  // namespace diffsac
