#pragma once

#include <torch/torch.h>

#include <cmath>
#include <memory>
#include <vector>

#include "lab/torch/denoiser.h"

namespace diffsac {

inline DenoiserOptions SmallOptions(const std::string& kind, int encoder_layers = 2) {
  DenoiserOptions options;
  options.kind = FromString<DenoiserKind>(kind);
  options.width = 16;
  options.heads = 4;
  options.encoder_layers = encoder_layers;
  options.layers = 2;
  options.inlier_head = encoder_layers > 0;
  return options;
}

/// Fills every weight with a fixed wave, so that no output is trivially zero.
inline void FillWithWave(Denoiser& network) {
  const torch::NoGradGuard no_grad;
  int index = 0;
  for (auto& parameter : network.parameters()) {
    ++index;
    float* values = parameter.data_ptr<float>();
    for (std::int64_t i = 0; i < parameter.numel(); ++i)
      values[i] = static_cast<float>(0.3 * std::sin(0.7 * static_cast<double>(i) + 1.3 * index));
  }
}

/// A feature set whose values come from `rng`.
inline FeatureSet RandomFeatures(int points, int columns, Rng rng) {
  FeatureSet set;
  set.values.resize(points, columns);
  for (int i = 0; i < points; ++i)
    for (int j = 0; j < columns; ++j) set.values(i, j) = static_cast<float>(rng.Normal());
  return set;
}

inline PointBatch BatchOf(const std::vector<FeatureSet>& sets) {
  std::vector<const FeatureSet*> pointers;
  for (const auto& set : sets) pointers.push_back(&set);
  return MakePointBatch(pointers);
}

inline torch::Tensor RandomTensor(std::vector<std::int64_t> sizes, Rng rng) {
  auto tensor = torch::empty(sizes);
  for (std::int64_t i = 0; i < tensor.numel(); ++i) tensor.data_ptr<float>()[i] = static_cast<float>(rng.Normal());
  return tensor;
}

inline double MaxDifference(const torch::Tensor& a, const torch::Tensor& b) {
  return (a - b).abs().max().item<double>();
}

}  // namespace diffsac
