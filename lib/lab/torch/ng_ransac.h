#pragma once

#include <torch/nn/modules/linear.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "diffsac/problem/point_features.h"
#include "lab/options/options.h"
#include "lab/torch/context_block.h"
#include "lab/torch/weight_network.h"

namespace diffsac {

/// What the network's value x of a point becomes before it is divided by the sum over the points: exp x, or
/// 1 / (1 + exp −x), as in the official program, where no point is ever much better than one that is surely good.
enum class NgRansacOutput { kSoftmax, kSigmoid };
template <>
inline constexpr auto kEnumNames<NgRansacOutput> = NamesOf<NgRansacOutput>({{NgRansacOutput::kSoftmax, "softmax"},
                                                                            {NgRansacOutput::kSigmoid, "sigmoid"}});

/// The group `network` of `method: ng_ransac`.
struct NgRansacNetworkOptions {
  PointFeaturesOptions features;
  int width = 128;
  int blocks = 12;
  NgRansacOutput output = NgRansacOutput::kSoftmax;
  void Bind(OptionsBinder& b);
  /// A network of these options has at least so many.
  std::int64_t LeastWeights() const { return std::int64_t{blocks} * width * width; }
};

/// The network of Brachmann and Rother, "Neural-guided RANSAC", ICCV 2019: a linear layer, residual blocks of
/// point-wise linear layers with context normalisation, a linear layer to one value a point. A softmax over the points
/// makes it the categorical distribution from which minimal sets are drawn (see NgRansacOutput).
class NgRansacNetwork : public WeightNetwork {
 public:
  using Options = NgRansacNetworkOptions;
  static constexpr const char* kMethod = "ng_ransac";

  NgRansacNetwork(const NgRansacNetworkOptions& options, int input_width, Rng rng);
  /// log p(y; w) [B, N], sums to 1 in p over a problem's points; −1e9 or less for padding.
  torch::Tensor LogWeights(const PointBatch& batch);
  torch::Tensor Weights(const PointBatch& batch) override;

 private:
  torch::nn::Linear input_{nullptr};
  std::vector<std::shared_ptr<ContextBlock>> blocks_;
  torch::nn::Linear output_{nullptr};
  NgRansacOutput kind_;
};

}  // namespace diffsac
