#include <torch/torch.h>

#include <algorithm>
#include <cmath>

#include "diffsac/core/parallel.h"
#include "lab/options/options.h"
#include "lab/torch/clnet.h"
#include "lab/train/batch_tensors.h"
#include "lab/train/consensus_loss.h"
#include "lab/train/expected_loss.h"
#include "lab/train/network_learner.h"

namespace diffsac {
namespace {

/// The group `clnet` of a training configuration: Zhao et al., "Progressive correspondence pruning by consensus
/// learning", ICCV 2021.
struct ClnetLosses {
  /// α of the adaptive temperature exp(−(d_thr − d) / (α d_thr)) of an inlier at distance d from the true model.
  double temperature = 0.5;
  double regression_weight = 0.5;
  double regression_start = 0.2;
  static constexpr const char* kHelp = "CLNet's losses (docs/clnet.md)";
  void Bind(OptionsBinder& b) {
    b.Field("temperature", temperature, Positive())
        .Help("α of the adaptive temperature exp(−(1 − d/ε) / α) of an inlier at distance d from the true model");
    b.Field("regression_weight", regression_weight, AtLeast(0)).Help("of the model regression loss");
    b.Field("regression_start", regression_start, Within(0.0, 1.0))
        .Help("share of the iterations after which it counts");
  }
};

class ClnetLearner : public NetworkLearner<WeightedEstimator, WeightTraining<ClnetNetwork, ClnetLosses>> {
 public:
  using NetworkLearner::NetworkLearner;
  std::vector<std::string> loss_names() const override {
    return {"loss_pruning", "loss_candidates", "loss_regression", "kept_inliers"};
  }
  Loss Compute(const std::vector<TrainingItem>& items, std::int64_t iteration,
               const std::vector<double>& shares) override;

 private:
  struct Truth {
    torch::Tensor inliers, temperature;  // [B, N]
  };
  Truth MakeTruth(const std::vector<TrainingItem>& items, std::int64_t points) const;
  torch::Tensor Regression(const std::vector<TrainingItem>& items, ClnetNetwork& network, const ClnetOutput& output,
                           std::int64_t points) const;
};

ClnetLearner::Truth ClnetLearner::MakeTruth(const std::vector<TrainingItem>& items, std::int64_t points) const {
  std::vector<std::vector<float>> inliers, distances;
  for (const auto& item : items) {
    inliers.push_back(item.inliers);
    const auto exact = TruthDistances(*item.example);
    auto& row = distances.emplace_back(item.inliers.size(), 1.0f);  // without a true model no label is in doubt
    for (std::size_t i = 0; i < exact.size(); ++i)
      row[i] = std::isfinite(exact[i]) ? static_cast<float>(std::min(exact[i], 1.0)) : 1.0f;
  }
  Truth truth;
  truth.inliers = PadRows(inliers, points, 0.0f);
  truth.temperature =
      AdaptiveTemperature(PadRows(distances, points, 1.0f), truth.inliers, own_.learning.temperature).to(device_);
  truth.inliers = truth.inliers.to(device_);
  return truth;
}

torch::Tensor ClnetLearner::Regression(const std::vector<TrainingItem>& items, ClnetNetwork& network,
                                       const ClnetOutput& output, std::int64_t points) const {
  std::vector<LinearFit> fits(items.size());
  for (std::size_t b = 0; b < items.size(); ++b) fits[b] = MakeLinearFit(*items[b].example);
  const auto candidates = network.CandidateWeights(output);
  const auto weights =
      torch::zeros({candidates.size(0), points}, candidates.options()).scatter_add(1, output.index, candidates);
  return RegressionLoss(weights, fits);
}

Learner::Loss ClnetLearner::Compute(const std::vector<TrainingItem>& items, std::int64_t iteration,
                                    const std::vector<double>& shares) {
  const auto points = CollatePoints(items);
  auto& network = dynamic_cast<ClnetNetwork&>(*network_->module);
  const auto output = network.Run(points.To(device_));
  const auto truth = MakeTruth(items, points.max_points());
  const auto entropy = [&](const torch::Tensor& logits, const torch::Tensor& index, const torch::Tensor& mask) {
    return BalancedCrossEntropy(logits, truth.inliers.gather(1, index), truth.temperature.gather(1, index), mask);
  };
  torch::Tensor pruning = torch::zeros({}, output.logits.options());
  for (const auto& stage : output.stages)
    pruning = pruning + entropy(stage.local, stage.index, stage.mask) + entropy(stage.global, stage.index, stage.mask);
  const auto candidates = entropy(output.logits, output.index, output.mask);
  auto total = pruning + candidates;
  const auto regression = Regression(items, network, output, points.max_points()).to(device_, total.scalar_type());
  const auto& train = own_.learning;
  if (iteration >= train.regression_start * static_cast<double>(options_.train.iterations))
    total = total + train.regression_weight * regression;
  const auto kept = truth.inliers.gather(1, output.index) * output.mask.to(torch::kFloat);
  const double share = (kept.sum() / truth.inliers.sum().clamp_min(1.0)).item<double>();
  return {shares[0] * total, {pruning.item<double>(), candidates.item<double>(), regression.item<double>(), share}};
}

const RegisteredLearner<ClnetLearner::Training, ClnetLearner> kClnet(
    "clnet", "Progressive pruning of correspondences, and a weighted fit (Zhao et al., ICCV 2021).");

}  // namespace
}  // namespace diffsac
