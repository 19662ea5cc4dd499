#pragma once

#include <torch/nn/module.h>
#include <torch/types.h>

#include <string>
#include <vector>

namespace diffsac {

/// A running average of a network's weights, from which one samples: shadow ← d·shadow + (1 − d)·weight, with
/// d = min(decay, (1 + n)/(10 + n)) after n updates.
class ExponentialMovingAverage {
 public:
  ExponentialMovingAverage(const torch::nn::Module& module, double decay);
  void Update(const torch::nn::Module& module);
  /// Writes the averaged weights into a network of the same architecture.
  void CopyTo(torch::nn::Module& module) const;

  const std::vector<torch::Tensor>& shadow() const { return shadow_; }
  std::vector<torch::Tensor>& shadow() { return shadow_; }
  std::int64_t updates() const { return updates_; }
  void set_updates(std::int64_t updates) { updates_ = updates; }

 private:
  double decay_;
  std::int64_t updates_ = 0;
  std::vector<torch::Tensor> shadow_;
};

}  // namespace diffsac
