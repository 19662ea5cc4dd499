#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "diffsac/core/safetensors.h"
#include "diffsac/guidance/engine/kernels.h"
#include "diffsac/guidance/engine/network_options.h"

namespace diffsac {

/// A trained network of kind `pooled` without LibTorch: weights packed once, one pass over the points for each layer,
/// one problem at a time. The same mathematics as the network that was trained (lab/torch/denoiser.h,
/// lab/torch/pooled_block.h); outputs agree to 1e-4 (tests/lab/torch/cpu_denoiser_test.cpp). Const calls may run at
/// the same time, each with its own Workspace.
class CpuDenoiser {
 public:
  /// What an architecture has that this class has not, in words; empty: nothing.
  static std::string Missing(const NetworkOptions& options);

  /// Reads the averaged weights. Throws Error naming file and tensor for weights that are not this architecture's.
  CpuDenoiser(const NetworkOptions& options, const FeatureColumns& columns, SafetensorsFile* file,
              const Kernels& kernels = BestKernels());
  ~CpuDenoiser();

  /// Memory of one call after another; grows to the largest problem.
  struct Workspace {
    int points = 0;                              ///< Of the encoded problem.
    std::vector<float> context;                  ///< points × W: what the encoder says.
    std::vector<float> agreements;               ///< points × M, for `relation`.
    std::vector<float> logits;                   ///< `points` inlier logits; empty without the head.
    std::vector<float> rows, scratch, constant;  ///< Of one copy while it is denoised.
  };

  /// features: `points` rows of the columns' width. Fills context, agreements and logits.
  void Encode(const float* features, int points, Workspace* work) const;
  /// Keeps only these of the encoded points, in this order.
  void Keep(std::span<const int> kept, Workspace* work) const;
  /// The raw output for `copies` rows of c_t at time t, into out.
  void Denoise(const float* c_t, int copies, double t, Workspace* work, float* out) const;

  int width() const { return width_; }
  std::int64_t parameters() const { return parameters_; }
  const Kernels& kernels() const { return kernels_; }

 private:
  struct Reader;
  struct Block;
  void Apply(const Block& block, float* rows, int points, Workspace* work) const;
  void AddRelations(const float* c_t, Workspace* work) const;

  const Kernels& kernels_;
  int width_, feature_width_, first_residual_;
  bool relation_;
  std::int64_t parameters_ = 0;
  std::vector<std::vector<float>> weights_;  ///< What the packed layers point into.
  PackedLinear input_points_{}, time_hidden_{}, time_output_{};
  PackedNorm ln_encoder_{}, ln_post_{};
  const float* inlier_ = nullptr;
  const float* output_ = nullptr;
  float inlier_bias_ = 0.0f, output_bias_ = 0.0f;
  PackedLinear input_confidence_{};
  int confidence_inputs_ = 1;
  std::vector<float> sharpness_;
  std::vector<Block> encoder_, decoder_;
};

}  // namespace diffsac
