#pragma once

#include "lab/torch/denoiser_base.h"

namespace diffsac {

/// Blocks over the points before and after c_t enters, the encoder shared by all copies and steps; which blocks, the
/// options' `kind` says. Same inputs and outputs as the paper's network.
class BlockDenoiser : public DenoiserBase {
 public:
  BlockDenoiser(const DenoiserOptions& options, const FeatureColumns& columns, Rng rng);
};

}  // namespace diffsac
