#include "lab/torch/clnet.h"

#include <torch/torch.h>

#include <algorithm>
#include <cmath>

#include "lab/config/registered_learned_estimator.h"
#include "lab/torch/initialize.h"
#include "lab/torch/weighted_estimator.h"

namespace diffsac {
namespace nn = torch::nn;

namespace {

constexpr int kBlocksBefore = 2, kBlocksBetween = 2, kBlocksAfter = 1, kFinalBlocks = 2;
constexpr float kFar = 1e30f;

// values: [B, N, C], index: [B, M] -> [B, M, C].
torch::Tensor TakePoints(const torch::Tensor& values, const torch::Tensor& index) {
  return values.gather(1, index.unsqueeze(-1).expand({-1, -1, values.size(2)}));
}

// Of each problem its own share of points, the best first; a problem's choice does not depend on its batch mates.
torch::Tensor BestPoints(const torch::Tensor& scores, const torch::Tensor& mask, double keep, int fewest,
                         torch::Tensor* kept_mask) {
  const auto lengths = mask.sum(1);
  auto counts = (lengths.to(torch::kDouble) * keep).ceil().to(torch::kLong).clamp_min(fewest);
  counts = torch::minimum(counts, lengths);
  const std::int64_t most = counts.max().item<std::int64_t>();
  const auto ranked = scores.detach().masked_fill(mask.logical_not(), -kFar).argsort(/*stable=*/true, 1, true);
  *kept_mask = torch::arange(most, counts.options()).unsqueeze(0) < counts.unsqueeze(1);
  return ranked.slice(1, 0, most);
}

}  // namespace

void ClnetNetworkOptions::Bind(OptionsBinder& b) {
  b.Field("features", features).Help("what the network sees of a point");
  b.Field("width", width, Within(4, 4096)).Help("channels");
  b.Field("neighbors", neighbors, Within(1, 1024)).Help("k of each pruning's graph; so many prunings");
  b.Field("annulus", annulus, Within(1, 1024)).Help("neighbours in an annulus; divides every k");
  b.Field("keep", keep, Within(0.01, 1.0)).Help("share of the points that a pruning keeps");
  b.Field("fewest", fewest, Within(2, 100000)).Help("a pruning keeps at least so many points");
  b.Require(!neighbors.empty(), "neighbors", "one number for each pruning, at least one");
  const bool divides = std::all_of(neighbors.begin(), neighbors.end(), [&](int k) { return k % annulus == 0; });
  b.Require(divides, "annulus", "a divisor of every number in neighbors");
}

std::int64_t ClnetNetworkOptions::LeastWeights() const {
  std::int64_t squares = 0;
  for (const int k : neighbors) squares += annulus + k / annulus;  // of the annular convolution
  return squares * width * width;
}

torch::Tensor NearestInFeatures(const torch::Tensor& features, const torch::Tensor& mask, int neighbors) {
  const torch::NoGradGuard no_grad;
  const auto z = features.detach();
  const auto norms = z.square().sum(-1);
  auto distances =
      torch::baddbmm(norms.unsqueeze(1), z, z.transpose(1, 2), 1.0, -2.0);  // up to the own norm of each row
  distances = distances.masked_fill(mask.logical_not().unsqueeze(1), kFar);
  distances.diagonal(0, 1, 2).fill_(-kFar);
  const auto sorted = std::get<1>(distances.topk(std::min<std::int64_t>(neighbors, z.size(1)), -1, /*largest=*/false));
  const auto last = (mask.sum(1, true) - 1).clamp_min(0);                                         // [B, 1]
  const auto place = torch::minimum(torch::arange(neighbors, last.options()).unsqueeze(0), last)  // [B, k]
                         .clamp_max(sorted.size(2) - 1);
  return sorted.gather(2, place.unsqueeze(1).expand({-1, z.size(1), -1}));
}

torch::Tensor ConsensusGraph(const torch::Tensor& z, const torch::Tensor& w) {
  const auto degree = w * w.sum(1, true) + 1.0;
  const auto root = degree.rsqrt().unsqueeze(-1);  // [B, N, 1]
  const auto weight = w.unsqueeze(-1) * root;
  return weight * torch::bmm(weight.transpose(1, 2), z) + root.square() * z;
}

AnnularConvolution::AnnularConvolution(std::int64_t width, int neighbors, int annulus, Rng rng)
    : neighbors_(neighbors), annulus_(annulus) {
  const std::int64_t rings = neighbors / annulus;
  center_ = register_module("center", MakeLinear({width, width}, rng.Fork("center")));
  ring_ = register_module("ring", MakeLinear(nn::LinearOptions(width, annulus * width).bias(false), rng.Fork("ring")));
  ring_norm_ = register_module("ring_norm", std::make_shared<ContextNorm>(rings * width));
  join_ = register_module("join", MakeLinear({rings * width, width}, rng.Fork("join")));
  join_norm_ = register_module("join_norm", std::make_shared<ContextNorm>(width));
}

// A kernel over the edges [z_i, z_i − z_j] of a ring is linear, so that its part of z_j can be computed once a point
// and gathered, and its parts of z_i are one matrix.
torch::Tensor AnnularConvolution::Forward(const torch::Tensor& z, const torch::Tensor& mask,
                                          const torch::Tensor& shares) {
  const std::int64_t batch = z.size(0), points = z.size(1), width = z.size(2), rings = neighbors_ / annulus_;
  const auto nearest = NearestInFeatures(z, mask, neighbors_).view({batch, points, rings, annulus_});
  const auto parts = ring_(z).view({batch, points, annulus_, width});
  const auto first = torch::arange(batch, nearest.options()).view({batch, 1, 1}) * points;
  torch::Tensor sum = center_(z).unsqueeze(2);  // [B, N, 1, W]
  for (int m = 0; m < annulus_; ++m) {
    const auto rows = (nearest.select(3, m) + first).flatten();
    sum = sum -
          parts.select(2, m).reshape({batch * points, width}).index_select(0, rows).view({batch, points, rings, width});
  }
  const auto hidden = ring_norm_->Forward(sum.flatten(2), shares);
  return join_norm_->Forward(join_(hidden), shares);
}

ClnetPruning::ClnetPruning(std::int64_t input_width, std::int64_t width, int neighbors, int annulus, Rng rng) {
  const auto blocks = [&](const std::string& name, int count) {
    Blocks made;
    for (int i = 0; i < count; ++i)
      made.push_back(
          register_module(name + std::to_string(i), std::make_shared<ContextBlock>(width, rng.Fork(name, i))));
    return made;
  };
  const auto linear = [&](const char* name, std::int64_t in, std::int64_t out) {
    return register_module(name, MakeLinear({in, out}, rng.Fork(name)));
  };
  input_ = linear("input", input_width, width);
  before_ = blocks("before", kBlocksBefore);
  annular_ =
      register_module("annular", std::make_shared<AnnularConvolution>(width, neighbors, annulus, rng.Fork("annular")));
  between_ = blocks("between", kBlocksBetween);
  local_ = linear("local", width, 1);
  graph_ = linear("graph", width, width);
  graph_norm_ = register_module("graph_norm", std::make_shared<ContextNorm>(width));
  after_ = blocks("after", kBlocksAfter);
  global_ = linear("global", width, 1);
}

torch::Tensor ClnetPruning::Forward(const torch::Tensor& x, ClnetStage* stage) {
  const auto shares = MeanShares(stage->mask, x.size(0), x.size(1), x.options());
  auto z = torch::relu(input_(x));
  for (auto& block : before_) z = block->Forward(z, shares);
  z = z + annular_->Forward(z, stage->mask, shares);
  for (auto& block : between_) z = block->Forward(z, shares);
  stage->local = local_(z).squeeze(-1);
  const auto agreement = torch::tanh(torch::relu(stage->local)) * stage->mask.to(z.dtype());
  z = z + graph_norm_->Forward(graph_(ConsensusGraph(z, agreement)), shares);
  for (auto& block : after_) z = block->Forward(z, shares);
  stage->global = global_(z).squeeze(-1);
  return z;
}

ClnetNetwork::ClnetNetwork(const ClnetNetworkOptions& options, int input_width, Rng rng) : options_(options) {
  for (std::size_t i = 0; i < options.neighbors.size(); ++i) {
    // Later prunings see what the one before said of their points.
    const int scores = i > 0 ? 2 : 0;
    prunings_.push_back(
        register_module("pruning" + std::to_string(i),
                        std::make_shared<ClnetPruning>(input_width + scores, options.width, options.neighbors[i],
                                                       options.annulus, rng.Fork("pruning", i))));
  }
  for (int i = 0; i < kFinalBlocks; ++i)
    final_.push_back(register_module("final" + std::to_string(i),
                                     std::make_shared<ContextBlock>(options.width, rng.Fork("final", i))));
  output_ = register_module("output", MakeLinear({options.width, 1}, rng.Fork("output")));
}

ClnetOutput ClnetNetwork::Run(const PointBatch& batch) {
  ClnetOutput output;
  const auto longs = torch::TensorOptions(torch::kLong).device(batch.features.device());
  auto x = batch.features;
  auto index = torch::arange(batch.max_points(), longs).unsqueeze(0).expand({batch.size(), -1});
  auto mask =
      batch.mask.defined() ? batch.mask : torch::ones({batch.size(), batch.max_points()}, longs.dtype(torch::kBool));
  torch::Tensor z;
  for (auto& pruning : prunings_) {
    ClnetStage stage{index, mask, {}, {}};
    z = pruning->Forward(x, &stage);
    const auto kept = BestPoints(stage.global, stage.mask, options_.keep, options_.fewest, &mask);
    index = index.gather(1, kept);
    const auto scores = torch::stack({torch::tanh(stage.local), torch::tanh(stage.global)}, -1);
    x = torch::cat({TakePoints(batch.features, index), TakePoints(scores, kept)}, -1);
    z = TakePoints(z, kept);
    output.stages.push_back(stage);
  }
  const auto shares = MeanShares(mask, z.size(0), z.size(1), z.options());
  for (auto& block : final_) z = block->Forward(z, shares);
  output.index = index;
  output.mask = mask;
  output.logits = output_(z).squeeze(-1);
  return output;
}

torch::Tensor ClnetNetwork::CandidateWeights(const ClnetOutput& output) const {
  const auto real = output.mask.to(output.logits.dtype());
  const auto strict = torch::tanh(torch::relu(output.logits)) * real;
  const auto enough = ((strict > 0).sum(1, true) >= options_.fewest / 2).expand_as(strict);
  return torch::where(enough, strict, torch::sigmoid(output.logits) * real);
}

torch::Tensor ClnetNetwork::Weights(const PointBatch& batch) {
  const auto output = Run(batch);
  const auto weights = CandidateWeights(output);
  return torch::zeros({batch.size(), batch.max_points()}, weights.options()).scatter_add(1, output.index, weights);
}

const RegisteredLearnedEstimator<WeightedEstimator, WeightedEstimatorOptions, LearnedWeights> kClnet(
    "clnet", "A weighted fit of the points that progressive pruning keeps (docs/clnet.md).",
    DefaultWeightedOptions("clnet"), LoadWeightsOfRow<ClnetNetwork>);

}  // namespace diffsac
