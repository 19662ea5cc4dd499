#pragma once

#include <torch/types.h>

#include <cstdint>
#include <span>
#include <vector>

#include "diffsac/denoiser/point_batch.h"
#include "diffsac/diffusion/reverse_sampler.h"
#include "diffsac/methods/diffsac_network.h"

namespace diffsac {

/// Confidences of a batch: float, on the CPU, [B, κ, N]; −∞ for points that were not decoded.
struct Denoised {
  torch::Tensor final;               ///< ĉ_0
  std::vector<torch::Tensor> steps;  ///< the prediction of each network call, in their order; empty unless asked for
  std::vector<double> times;         ///< diffusion times of these
};

/// What the paper's reverse process makes of a batch whose points are encoded.
struct DenoisingOptions {
  int copies = 20;             ///< κ
  int max_decoded_points = 0;  ///< decode only so many of the likeliest points; 0: all
  bool keep_steps = false;
};

/// context: of the whole batch, on the network's device; it is cut down to the decoded points. seeds: of the problems;
/// a problem's noise depends on its own alone.
Denoised Denoise(const DiffsacNetwork& network, const ReverseSampler& sampler, const DenoisingOptions& options,
                 const PointBatch& batch, std::span<const std::uint64_t> seeds, Context context);

}  // namespace diffsac
