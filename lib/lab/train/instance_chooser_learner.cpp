#include <torch/torch.h>

#include <algorithm>
#include <cmath>

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/vanishing_point_chooser.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/problem/vanishing_point_pool.h"
#include "diffsac/ransac/samplers/weighted_sampler.h"
#include "lab/ground_truth/task_truth.h"
#include "lab/options/options.h"
#include "lab/torch/set_scorer_module.h"
#include "lab/train/learner.h"

namespace diffsac {
namespace {

/// What a hypothesis is worth at so many degrees from a true direction: the mean of its shares in AUC@5° and AUC@10°.
constexpr float kNearDegrees = 5.0f, kFarDegrees = 10.0f;

/// Share of the choices in training that are drawn by what the network says, in place of its best.
constexpr double kExplored = 0.3;
/// Of what each layer adds, in training.
constexpr double kDropout = 0.1;

/// The group `structure_chooser` of a training configuration.
struct ChooserLearning {
  int draws = 1500;
  int most = 5;
  void Bind(OptionsBinder& b) {
    b.Field("draws", draws, Within(10, 100000)).Help("minimal sets of an image, drawn by the segments' lengths");
    b.Field("most", most, Within(1, 20)).Help("structures that are chosen one after the other in a training step");
  }
};

struct ChooserTraining : LearnerOptions {
  SetScorerOptions network;
  ChooserLearning learning;
  PointFeaturesOptions unused;  ///< A trainer's items have features of points.

  explicit ChooserTraining(Task) { unused.kinds = {PointFeature::kCoordinates}; }
  const PointFeaturesOptions& features() const override { return unused; }
  void Bind(OptionsBinder& b) override {
    b.Field("network", network).Help("what must be the same in training and in inference");
    b.Field("structure_chooser", learning).Help("how the choice is learned (docs/several.md)");
  }
};

std::vector<Eigen::Vector3d> DrawHypotheses(const NormalizedProblem& space, const Eigen::VectorXd& weights, int count,
                                            const Rng& rng) {
  WeightedSampler sampler({weights.data(), static_cast<std::size_t>(weights.size())}, VanishingPoint::kMinimalSize,
                          rng);
  const std::vector<int> sets = DrawSets(sampler, VanishingPoint::kMinimalSize, count);
  std::vector<Eigen::Vector3d> models;
  VanishingPoint::Parameters model;
  for (std::size_t i = 0; i + 1 < sets.size(); i += 2)
    if (VanishingPoint::SolveMinimal(space.points(), sets.data() + i, &model) > 0) models.push_back(model);
  return models;
}

/// A pool with what each of its models is worth for each true one: values[k · H + h].
struct JudgedPool {
  VanishingPointPool pool;
  std::vector<float> values;
  int instances = 0;

  JudgedPool(const Example& example, int draws, const Rng& rng) {
    const NormalizedProblem space(example.problem);
    const Eigen::VectorXd weights = PointWeights(example.problem);
    pool = MakeVanishingPointPool(space.points(), PoolLengths(weights), DrawHypotheses(space, weights, draws, rng));
    instances = static_cast<int>(example.truth.instances.size());
    const auto angle_of = TruthOf(Task::kVanishingPoint).instance_angle;
    for (const ModelParameters& truth : example.truth.instances)
      for (const Eigen::Vector3d& model : pool.models) {
        const auto angle = static_cast<float>(angle_of(model, truth, example));
        values.push_back(0.5f * std::max(0.0f, 1.0f - angle / kNearDegrees) +
                         0.5f * std::max(0.0f, 1.0f - angle / kFarDegrees));
      }
  }
  int size() const { return static_cast<int>(pool.models.size()); }
};

/// The pools of a batch, padded to the largest.
struct PoolBatch {
  torch::Tensor features, pairs, there;  ///< [B, H, F], [B, H, H, P], [B, H]
  torch::Tensor values;                  ///< [B, K, H]
  torch::Tensor instances;               ///< [B]

  explicit PoolBatch(const std::vector<std::unique_ptr<JudgedPool>>& pools) {
    std::int64_t most = 1, kinds = 1;
    for (const auto& pool : pools) {
      most = std::max<std::int64_t>(most, pool->size());
      kinds = std::max<std::int64_t>(kinds, pool->instances);
    }
    const auto batch = static_cast<std::int64_t>(pools.size());
    features = torch::zeros({batch, most, kPoolFeatures});
    pairs = torch::zeros({batch, most, most, kPoolPairs});
    there = torch::zeros({batch, most}, torch::kBool);
    values = torch::zeros({batch, kinds, most});
    instances = torch::zeros({batch}, torch::kLong);
    for (std::int64_t b = 0; b < batch; ++b) Put(*pools[static_cast<std::size_t>(b)], b);
  }

 private:
  void Put(const JudgedPool& judged, std::int64_t b) {
    const std::int64_t count = judged.size();
    instances[b] = judged.instances;
    if (count == 0) return;
    const auto copy = [](const auto& rows, torch::IntArrayRef shape) {
      return torch::from_blob(const_cast<float*>(rows.data()), shape, torch::kFloat).clone();
    };
    const torch::indexing::Slice first(0, count);
    features.index_put_({b, first}, copy(judged.pool.features, {count, kPoolFeatures}));
    pairs.index_put_({b, first, first}, copy(judged.pool.pairs, {count, count, kPoolPairs}));
    there.index_put_({b, first}, true);
    if (judged.instances > 0)
      values.index_put_({b, torch::indexing::Slice(0, judged.instances), first},
                        copy(judged.values, {judged.instances, count}));
  }
};

/// Learns what a hypothesis adds to those that were taken, along the choices that the network itself makes.
class InstanceChooserLearner : public Learner {
 public:
  using Training = ChooserTraining;

  InstanceChooserLearner(const TrainConfig& options, const Training& own, const torch::Device& device, int threads)
      : options_(options),
        own_(own),
        device_(device),
        threads_(threads),
        features_(own.unused, options.task),
        network_(Make()),
        averaged_(Make()) {
    averaged_->eval();
    if (options.task != Task::kVanishingPoint)
      throw Error("method structure_chooser learns task vanishing_point, not " + ToString(options.task));
  }

  torch::nn::Module& network() override { return *network_; }
  torch::nn::Module& averaged() override { return *averaged_; }
  const PointFeatures& features() const override { return features_; }
  std::vector<std::string> loss_names() const override { return {"loss_gain", "value_taken"}; }
  Loss Compute(const std::vector<TrainingItem>& items, std::int64_t iteration,
               const std::vector<double>& shares) override;

  std::unique_ptr<RobustEstimator> AveragedEstimator() const override {
    ClassicalOptions row;
    row.max_iterations = own_.learning.draws;
    row.sampling.sampler = MinimalSamplerKind::kWeighted;
    row.instances.search = InstanceSearch::kChosen;
    row.instances.most = kMostChosen;
    row.instances.chosen_by = std::make_shared<VanishingPointChooser>(averaged_->Copy());
    return std::make_unique<ClassicalEstimator>(row);
  }

 private:
  static constexpr int kMostChosen = 8;

  std::shared_ptr<SetScorerModule> Make() const {
    auto module = std::make_shared<SetScorerModule>(own_.network, kPoolFeatures, kPoolPairs, Rng(options_.train.seed));
    module->to(device_);
    return module;
  }
  PoolBatch PoolsOf(const std::vector<TrainingItem>& items) const;

  TrainConfig options_;
  Training own_;
  torch::Device device_;
  int threads_;
  PointFeatures features_;
  std::shared_ptr<SetScorerModule> network_, averaged_;
};

PoolBatch InstanceChooserLearner::PoolsOf(const std::vector<TrainingItem>& items) const {
  std::vector<std::unique_ptr<JudgedPool>> pools(items.size());
  const Rng rng(options_.train.seed);
  ParallelFor(static_cast<std::int64_t>(items.size()), threads_, [&](std::int64_t i) {
    pools[i] = std::make_unique<JudgedPool>(*items[i].example, own_.learning.draws, rng.Fork("pool", items[i].index));
  });
  return PoolBatch(pools);
}

/// An element of each set: the likeliest, or for a share of the sets one drawn by exp(logit).
torch::Tensor Pick(const torch::Tensor& logits, const torch::Tensor& free, double explore) {
  const auto noise = -(-torch::rand_like(logits).clamp(1e-9, 1.0 - 1e-7).log()).log();
  const auto drawn = (torch::rand({logits.size(0), 1}, logits.options()) < explore).to(logits.scalar_type());
  return (logits + noise * drawn).masked_fill(free.logical_not(), -1e9).argmax(1, true);
}

Learner::Loss InstanceChooserLearner::Compute(const std::vector<TrainingItem>& items, std::int64_t iteration,
                                              const std::vector<double>& shares) {
  constexpr double kPerSet = 0.1;
  torch::manual_seed(options_.train.seed * 1000003 + static_cast<std::uint64_t>(iteration));
  const PoolBatch batch = PoolsOf(items);
  auto values = batch.features.clone();
  const auto side = torch::randint(0, 2, {values.size(0), 1, 1}).to(torch::kFloat) * 2.0 - 1.0;
  values.slice(2, kPoolFeatures - kPoolOddFeatures) *= side;  // Each image is as good as its mirror image.
  const auto there = batch.there.to(device_), worth = batch.values.to(device_);
  const auto embedded = network_->Embed(values.to(device_)), bias = network_->Bias(batch.pairs.to(device_));
  auto taken = torch::zeros_like(there, torch::kFloat), reached = torch::zeros_like(worth.select(2, 0));
  torch::Tensor total = torch::zeros({}, values.options()).to(device_);
  double active_sets = 0.0;
  const std::int64_t steps = std::min<std::int64_t>(own_.learning.most, batch.instances.max().item<std::int64_t>());
  for (std::int64_t step = 0; step < steps; ++step) {
    const auto logits = network_->Score(embedded, bias, there, taken, kDropout);
    const auto free = there.logical_and(taken < 0.5);
    const auto gain = std::get<0>((worth - reached.unsqueeze(-1)).clamp_min(0.0).max(1));
    const auto active = (batch.instances > step).to(torch::kFloat).to(device_);
    const auto losses = torch::binary_cross_entropy_with_logits(logits, gain, {}, {}, at::Reduction::None) * free;
    total = total + kPerSet * (losses.sum(1) * active).sum();
    active_sets += active.sum().item<double>();
    const auto pick = Pick(logits.detach(), free, kExplored);
    taken = taken.scatter(1, pick, 1.0);
    const auto of_pick = worth.gather(2, pick.unsqueeze(1).expand({-1, worth.size(1), 1})).squeeze(-1);
    reached = torch::maximum(reached, of_pick);
  }
  const double sets = std::max(1.0, active_sets);
  const double found = reached.sum().item<double>() / std::max(1.0, batch.instances.sum().item<double>());
  const auto loss = total / sets;
  return {shares[0] * loss, {loss.item<double>(), found}};
}

const RegisteredLearner<InstanceChooserLearner::Training, InstanceChooserLearner> kInstanceChooser(
    "structure_chooser", "Which of many hypotheses are the structures that a person means (docs/several.md).");

}  // namespace
}  // namespace diffsac
