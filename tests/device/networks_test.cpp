#include <ATen/autocast_mode.h>
#include <torch/torch.h>

#include <catch2/catch.hpp>

#include "device/test_device.h"
#include "estimate/tiny_network.h"
#include "lab/torch/clnet.h"
#include "lab/torch/diffsac_network.h"
#include "lab/torch/edge_block.h"
#include "lab/torch/losses.h"
#include "lab/torch/ng_ransac.h"
#include "lab/torch/test_networks.h"

namespace diffsac {
namespace {

using testing::TestDevice;

// The test's own device computes with the CPU's kernels.
double Tolerance() { return testing::OnOwnDevice() ? 1e-5 : 1e-3; }

constexpr int kColumns = 9, kFirstResidual = 3;

// Whose nearest neighbours and largest values are so by more than rounding.
PointBatch Ragged() { return BatchOf({RandomFeatures(21, kColumns, Rng(12)), RandomFeatures(17, kColumns, Rng(13))}); }

DenoiserOptions Options(const std::string& kind, int encoder_layers, bool extras) {
  auto options = SmallOptions(kind, encoder_layers);
  options.relation = extras;
  options.neighbors = 5;
  return options;
}

std::shared_ptr<Denoiser> Network(const DenoiserOptions& options) {
  auto network = std::make_shared<Denoiser>(options, FeatureColumns(kColumns, kFirstResidual), Rng(1));
  FillWithWave(*network);
  return network;
}

// Two times of one noise, and the gradients of a loss.
std::vector<torch::Tensor> Results(const DenoiserOptions& options, const torch::Device& device) {
  auto network = Network(options);
  network->to(device);
  const auto batch = Ragged().To(device);
  const auto c_t = RandomTensor({2, 3, 21}, Rng(4)).to(device);
  const auto context = network->Encode(batch);
  const auto first = network->Denoise(context, c_t, torch::full({1, 1}, 7.0, c_t.options()));
  const auto second = network->Denoise(context, c_t, torch::full({2, 3}, 3.0, c_t.options()));
  const auto mask = batch.mask.unsqueeze(1).expand_as(second);
  auto loss = DiffusionLoss(DiffusionLossKind::kBce, second, c_t, mask, 2.0);
  std::vector<torch::Tensor> results = {first, second};
  if (context.inlier_logits.defined()) {
    results.push_back(context.inlier_logits);
    loss = loss + context.inlier_logits.masked_select(batch.mask).square().mean();
  }
  loss.backward();
  for (const auto& parameter : network->parameters())
    if (parameter.grad().defined()) results.push_back(parameter.grad());
  for (auto& result : results) {
    CHECK(result.device() == device);
    result = result.detach().cpu();
  }
  return results;
}

void CheckNear(const std::vector<torch::Tensor>& there, const std::vector<torch::Tensor>& here) {
  REQUIRE(there.size() == here.size());
  for (std::size_t i = 0; i < here.size(); ++i) {
    CAPTURE(i);
    const double scale = std::max(1.0, here[i].abs().max().item<double>());
    CHECK(MaxDifference(there[i], here[i]) < Tolerance() * scale);
  }
}

}  // namespace

TEST_CASE("every denoiser computes on the device what it computes on the CPU, gradients included") {
  for (const char* kind : {"point_transformer", "pooled", "mlp", "dgcnn"})
    for (const int encoder_layers : {0, 2})
      for (const bool extras : {false, true}) {
        CAPTURE(kind, encoder_layers, extras);
        const auto options = Options(kind, encoder_layers, extras);
        CheckNear(Results(options, TestDevice()), Results(options, torch::kCPU));
      }
}

TEST_CASE("neighbours in mixed precision are those in single precision") {
  const auto type = TestDevice().type();
  const auto u = RandomTensor({2, 60, 32}, Rng(5)).to(TestDevice());
  const auto exact = NearestRows(u, {}, 8);
  at::autocast::set_autocast_enabled(type, true);
  at::autocast::set_autocast_dtype(type, torch::kBFloat16);
  const auto mixed = NearestRows(u, {}, 8);
  const bool multiplies_in_16_bits = torch::bmm(u, u.transpose(1, 2)).scalar_type() == torch::kBFloat16;
  at::autocast::clear_cache();
  at::autocast::set_autocast_enabled(type, false);
  CHECK(multiplies_in_16_bits);
  CHECK(torch::equal(exact.cpu(), mixed.cpu()));
}

TEST_CASE("networks that weigh points compute on the device what they compute on the CPU") {
  ClnetNetworkOptions clnet;
  clnet.width = 16;
  clnet.fewest = 8;
  NgRansacNetworkOptions ng_ransac;
  ng_ransac.width = 16;
  ng_ransac.blocks = 2;
  const auto weights = [&](bool first, const torch::Device& device) {
    std::shared_ptr<WeightNetwork> network;
    if (first)
      network = std::make_shared<ClnetNetwork>(clnet, kColumns, Rng(1));
    else
      network = std::make_shared<NgRansacNetwork>(ng_ransac, kColumns, Rng(1));
    network->to(device);
    return network->Weights(Ragged().To(device)).detach().cpu();
  };
  for (const bool first : {true, false}) CheckNear({weights(first, TestDevice())}, {weights(first, torch::kCPU)});
}

namespace {

std::vector<ReverseSamplerOptions> AllSamplers() {
  std::vector<ReverseSamplerOptions> all;
  for (const auto kind : {ReverseSamplerKind::kDdpm, ReverseSamplerKind::kRenoise, ReverseSamplerKind::kDdim,
                          ReverseSamplerKind::kDpmSolverPp}) {
    all.emplace_back().kind = kind;
    all.back().steps = 4;
  }
  const auto more = [&](const auto& change) {
    all.push_back(all[3]);
    change(all.back());
  };
  more([](ReverseSamplerOptions& o) { o.order = 1; });
  more([](ReverseSamplerOptions& o) { o.clip_x0 = false; });
  all.push_back(all[2]);
  all.back().ddim_eta = 1.0;
  return all;
}

// Of two problems of different sizes.
std::vector<Denoised> Run(const NetworkOptions& options, const DenoisingOptions& denoising,
                          const torch::Device& device) {
  auto network = TinyNetwork(Task::kLine, options);
  network->MoveTo(device);
  std::vector<FeatureSet> sets;
  const auto examples = TinyExamples(Task::kLine, 2);
  for (const auto& example : examples)
    sets.push_back(network->features.Compute(NormalizedProblem(example.problem), Rng(5).Fork("features")));
  const FeatureSet* pointers[] = {&sets[0], &sets[1]};
  const std::uint64_t seeds[] = {7, 8};
  return network->Run(denoising, pointers, seeds, 1);
}

void CheckNear(const std::vector<float>& there, const std::vector<float>& here) {
  REQUIRE(there.size() == here.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < here.size(); ++i)
    if (there[i] != here[i]) worst = std::max<double>(worst, std::abs(there[i] - here[i]));
  CHECK(worst < 100 * Tolerance());
}

void CheckSame(const NetworkOptions& options, const DenoisingOptions& denoising) {
  const auto there = Run(options, denoising, TestDevice()), here = Run(options, denoising, torch::kCPU);
  for (std::size_t b = 0; b < here.size(); ++b) {
    CheckNear(there[b].weights, here[b].weights);
    CheckNear(there[b].confidences, here[b].confidences);
    REQUIRE(there[b].steps.size() == here[b].steps.size());
    for (std::size_t k = 0; k < here[b].steps.size(); ++k) CheckNear(there[b].steps[k], here[b].steps[k]);
  }
}

}  // namespace

TEST_CASE("every reverse process on the device draws the confidences that it draws on the CPU") {
  auto options = TinyOptions();
  options.schedule.steps = 50;
  for (const auto& sampler : AllSamplers()) {
    CAPTURE(ToString(sampler.kind), sampler.order, sampler.ddim_eta);
    CheckSame(options, {sampler, 3, 0, true});
  }
}

TEST_CASE("few decoded points, no reverse process, and confidences without diffusion work on the device") {
  auto options = TinyOptions();
  ReverseSamplerOptions sampler;
  sampler.steps = 2;
  CheckSame(options, {sampler, 3, 16, true});
  CheckSame(options, {sampler, 0, 0, false});
  options.direct = true;
  CheckSame(options, {sampler, 3, 0, true});
}

}  // namespace diffsac
