#pragma once

#include <memory>
#include <span>
#include <vector>

#include "diffsac/estimators/diffsac_model.h"
#include "lab/torch/diffsac_network.h"
#include "lab/torch/tensor_sampler.h"

namespace diffsac {

/// The paper's reverse process by LibTorch, for a batch of problems at once, on the network's device. Borrows the
/// network.
class TensorInference : public DiffsacInference {
 public:
  /// Throws Error on bad options of the sampler.
  TensorInference(const DiffsacNetwork& network, const DenoisingOptions& options);
  bool Batches() const override { return true; }
  std::vector<Denoised> Run(std::span<const FeatureSet* const> features, std::span<const std::uint64_t> seeds,
                            int threads) const override;

 private:
  const DiffsacNetwork& network_;
  DenoisingOptions options_;
  std::unique_ptr<ReverseSampler> sampler_;
};

}  // namespace diffsac
