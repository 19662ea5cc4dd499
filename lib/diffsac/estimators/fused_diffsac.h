#pragma once

#include <memory>

#include "diffsac/estimators/diffsac_model.h"
#include "diffsac/network/engine/fused_denoiser.h"

namespace diffsac {

/// The network of a checkpoint in plain C++, for architectures that FusedDenoiser has. Throws Error naming the file.
std::shared_ptr<const DiffsacModel> LoadFusedDiffsac(const TrainedConfig& trained, const NetworkOptions& options);

}  // namespace diffsac
