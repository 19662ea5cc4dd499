#pragma once

#include <torch/nn/module.h>
#include <torch/nn/modules/linear.h>
#include <torch/nn/modules/normalization.h>

#include <memory>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/guidance/engine/set_scorer.h"

namespace diffsac {

/// A SetScorer in LibTorch, for training: the same tensors by the same names, in batches.
class SetScorerModule : public torch::nn::Module {
 public:
  SetScorerModule(const SetScorerOptions& options, int features, int pairs, const Rng& rng);

  /// The same in Eigen, with the weights as they are now.
  std::shared_ptr<const SetScorer> Copy() const;
  /// [B, H, width] of [B, H, features], and [B, heads · layers, H, H] of [B, H, H, pairs]: once for each set.
  torch::Tensor Embed(const torch::Tensor& values) { return input_(values); }
  torch::Tensor Bias(const torch::Tensor& pairs);
  /// Logits [B, H]. there: [B, H], true for elements, false for padding; taken: [B, H], 1 for those that were taken.
  /// dropout: of what each layer adds.
  torch::Tensor Score(const torch::Tensor& embedded, const torch::Tensor& bias, const torch::Tensor& there,
                      const torch::Tensor& taken, double dropout);

 private:
  struct Layer : torch::nn::Module {
    torch::nn::LayerNorm before_attention{nullptr}, before_hidden{nullptr};
    torch::nn::Linear attention{nullptr}, output{nullptr}, hidden{nullptr}, back{nullptr};
    Layer(const SetScorerOptions& options, const Rng& rng);
  };
  torch::Tensor Attend(Layer& layer, const torch::Tensor& x, const torch::Tensor& bias, const torch::Tensor& there);

  SetScorerOptions options_;
  int features_, pairs_;
  torch::nn::Linear input_{nullptr}, pair_hidden_{nullptr}, pair_output_{nullptr}, score_hidden_{nullptr},
      score_{nullptr};
  torch::nn::LayerNorm score_norm_{nullptr};
  torch::Tensor taken_;
  std::vector<std::shared_ptr<Layer>> layers_;
};

}  // namespace diffsac
