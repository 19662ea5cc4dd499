#pragma once

#include <torch/nn/module.h>

#include <vector>

namespace diffsac {

/// How much each point agrees with the points that are confident now: the one input of a denoiser that relates points
/// to each other rather than to their problem's means. Linear in N, tied to no task.
///
/// With g_i the unit preference vector of point i (its agreement with each of M hypotheses; after Toldo and Fusiello,
/// "Robust multiple structures estimation with J-linkage", ECCV 2008) and c its confidence now,
///
///   v(s) = Σ softmax(s c)_i g_i,   output_i(s) = cos(v(s), g_i),
///
/// for two sharpnesses s, which are learned: a flat one, near what all confident points have in common, and a sharp
/// one, near what the most confident say.
class PointRelation : public torch::nn::Module {
 public:
  static constexpr int kOutputs = 2;
  PointRelation();

  /// features [B, N, D] with residual features from column `first` on → g [B, N, M]; 0 for points that agree with no
  /// hypothesis, and for padding.
  static torch::Tensor Agreements(const torch::Tensor& features, int first);
  /// agreements: of Agreements; mask: [B, N] or undefined; c_t: [B, κ, N]. kOutputs tensors [B, κ, N], in [0, 1].
  std::vector<torch::Tensor> Forward(const torch::Tensor& agreements, const torch::Tensor& mask,
                                     const torch::Tensor& c_t);

 private:
  torch::Tensor log_sharpness_;  // [kOutputs]
};

}  // namespace diffsac
