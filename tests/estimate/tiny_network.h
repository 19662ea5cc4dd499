#pragma once

#include <memory>
#include <vector>

#include "diffsac/estimate/diffsac_estimator.h"
#include "lab/data/synthetic.h"
#include "lab/torch/diffsac_network.h"

namespace diffsac {

inline NetworkOptions TinyOptions() {
  NetworkOptions options;
  options.features.kinds = {PointFeature::kCoordinates, PointFeature::kResidual};
  options.features.residual_draws = 30;
  options.features.residual_kept = 4;
  options.denoiser.width = 16;
  options.denoiser.encoder_layers = 1;
  options.denoiser.layers = 1;
  return options;
}

/// An untrained network whose outputs are not all zero: every weight is a fixed wave.
inline std::shared_ptr<DiffsacNetwork> TinyNetwork(Task task, const NetworkOptions& options = TinyOptions()) {
  auto network = std::make_shared<DiffsacNetwork>(task, options, Rng(1));
  const torch::NoGradGuard no_grad;
  int index = 0;
  for (auto& parameter : network->module->parameters()) {
    ++index;
    for (std::int64_t i = 0; i < parameter.numel(); ++i)
      parameter.data_ptr<float>()[i] = static_cast<float>(0.3 * std::sin(0.7 * static_cast<double>(i) + 1.3 * index));
  }
  return network;
}

inline std::vector<Example> TinyExamples(Task task, int count, double outlier_ratio = 0.5) {
  SyntheticOptions options;
  options.outlier_ratio = {outlier_ratio, outlier_ratio};
  options.num_points = {40, 60};
  options.split = "test";
  const auto dataset = MakeSynthetic(task, options, 5);
  std::vector<Example> examples;
  for (int i = 0; i < count; ++i) examples.push_back(dataset->Get(i));
  return examples;
}

/// What RunBatch takes.
inline std::vector<const Problem*> PointersTo(const std::vector<Problem>& problems) {
  std::vector<const Problem*> pointers;
  for (const Problem& problem : problems) pointers.push_back(&problem);
  return pointers;
}

}  // namespace diffsac
