#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "diffsac/estimators/learned_model.h"
#include "diffsac/network/diffusion/reverse_sampler.h"
#include "diffsac/network/engine/network_options.h"

namespace diffsac {

/// What the reverse process is asked for.
struct DenoisingOptions {
  ReverseSamplerOptions sampler;
  int copies = 20;             ///< κ; 0: no reverse process, the inlier head alone
  int max_decoded_points = 0;  ///< decode only so many of the likeliest points; 0: all
  bool keep_steps = false;
};

/// What a network says of one problem of N points. Confidences are κ rows of N values, −∞ for points that were not
/// decoded.
struct Denoised {
  std::vector<float> weights;             ///< N inlier probabilities; empty without the inlier head.
  std::vector<float> confidences;         ///< ĉ_0; empty for no copies.
  std::vector<std::vector<float>> steps;  ///< The prediction of each network call, in their order, where they are kept.
  std::vector<double> times;              ///< Diffusion times of these.
};

/// A network and what it is asked for. Stateless: one may serve many threads.
class DiffsacInference {
 public:
  virtual ~DiffsacInference() = default;
  /// Whether several problems at once take less time than one after the other.
  virtual bool Batches() const = 0;
  /// features: of any number of problems; a problem's noise depends on its own seed alone. threads: of those that it
  /// makes itself (LibTorch uses its own).
  virtual std::vector<Denoised> Run(std::span<const FeatureSet* const> features, std::span<const std::uint64_t> seeds,
                                    int threads) const = 0;
};

/// A trained denoiser, whatever computes it: DiffsacNetwork (lab/torch, LibTorch) or FusedDiffsac (plain C++).
class DiffsacModel {
 public:
  virtual ~DiffsacModel() = default;
  virtual const LearnedModel& learned() const = 0;
  virtual const NetworkOptions& network_options() const = 0;
  virtual std::unique_ptr<DiffsacInference> Prepare(const DenoisingOptions& options) const = 0;
};

}  // namespace diffsac
