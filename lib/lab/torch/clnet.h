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

/// The group `network` of `method: clnet`.
struct ClnetNetworkOptions {
  PointFeaturesOptions features;
  int width = 100;
  std::vector<int> neighbors = {9, 6};
  int annulus = 3;
  double keep = 0.5;
  int fewest = 16;
  void Bind(OptionsBinder& b);
  /// A network of these options has at least so many.
  std::int64_t LeastWeights() const;
};

/// What one pruning said of the points it was given.
struct ClnetStage {
  torch::Tensor index;   ///< [B, M] places of its points in the problem
  torch::Tensor mask;    ///< [B, M] bool, true for real points
  torch::Tensor local;   ///< [B, M] logits of the local consensus
  torch::Tensor global;  ///< [B, M] logits of the global consensus, by which the better share is kept
};

struct ClnetOutput {
  std::vector<ClnetStage> stages;
  torch::Tensor index;   ///< [B, C] places of the candidates that are left
  torch::Tensor mask;    ///< [B, C]
  torch::Tensor logits;  ///< [B, C] of "is an inlier"
};

/// z_i W + Σ over annuli: the k nearest points in feature space, nearest first, in rings of `annulus`; each ring is
/// convolved with kernels that all rings share, a second convolution joins the rings.
class AnnularConvolution : public torch::nn::Module {
 public:
  AnnularConvolution(std::int64_t width, int neighbors, int annulus, Rng rng);
  torch::Tensor Forward(const torch::Tensor& z, const torch::Tensor& mask, const torch::Tensor& shares);

 private:
  int neighbors_, annulus_;
  torch::nn::Linear center_{nullptr};
  torch::nn::Linear ring_{nullptr};
  std::shared_ptr<ContextNorm> ring_norm_;
  torch::nn::Linear join_{nullptr};
  std::shared_ptr<ContextNorm> join_norm_;
};

/// Places [B, N, k] of the k nearest points in feature space, nearest first, the point itself being the first. A
/// problem of fewer points repeats its farthest.
torch::Tensor NearestInFeatures(const torch::Tensor& z, const torch::Tensor& mask, int neighbors);

/// D^(-1/2) (A + I) D^(-1/2) z with A_ij = w_i w_j, in time linear in N. z: [B, N, C]; w: [B, N] ≥ 0, 0 for padding.
torch::Tensor ConsensusGraph(const torch::Tensor& z, const torch::Tensor& w);

/// Local consensus over a dynamic graph, global consensus over a graph of the local scores.
class ClnetPruning : public torch::nn::Module {
 public:
  ClnetPruning(std::int64_t input_width, std::int64_t width, int neighbors, int annulus, Rng rng);
  /// x: [B, N, D]. Fills local and global; returns the features [B, N, width].
  torch::Tensor Forward(const torch::Tensor& x, ClnetStage* stage);

 private:
  using Blocks = std::vector<std::shared_ptr<ContextBlock>>;
  torch::nn::Linear input_{nullptr};
  Blocks before_, between_, after_;
  std::shared_ptr<AnnularConvolution> annular_;
  torch::nn::Linear local_{nullptr};
  torch::nn::Linear graph_{nullptr};
  std::shared_ptr<ContextNorm> graph_norm_;
  torch::nn::Linear global_{nullptr};
};

/// The network of Zhao et al., "Progressive correspondence pruning by consensus learning", ICCV 2021.
class ClnetNetwork : public WeightNetwork {
 public:
  using Options = ClnetNetworkOptions;
  static constexpr const char* kMethod = "clnet";
  /// Each point is compared with each: 1.6 GB for so many.
  static constexpr int kMostPoints = 20000;

  ClnetNetwork(const ClnetNetworkOptions& options, int input_width, Rng rng);
  ClnetOutput Run(const PointBatch& batch);
  /// tanh(relu(logit)) of the candidates, 0 for all others; sigmoid(logit) where that leaves fewer than `fewest` / 2
  /// points, so that there is something to fit.
  torch::Tensor Weights(const PointBatch& batch) override;
  torch::Tensor CandidateWeights(const ClnetOutput& output) const;

 private:
  ClnetNetworkOptions options_;
  std::vector<std::shared_ptr<ClnetPruning>> prunings_;
  std::vector<std::shared_ptr<ContextBlock>> final_;
  torch::nn::Linear output_{nullptr};
};

}  // namespace diffsac
