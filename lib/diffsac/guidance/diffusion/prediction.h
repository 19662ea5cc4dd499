#pragma once

#include "diffsac/core/enum_names.h"

namespace diffsac {

/// What a network that predicts c_0 puts out.
///   kMse  "mse": ĉ_0 itself (the paper's Algorithm 1); l = (prediction − c0)²
///   kBce  "bce": logits of [label = +1]; l is their cross-entropy (Chen et al., "Analog bits", ICLR 2023)
enum class DiffusionLossKind { kMse, kBce };
template <>
inline constexpr auto kEnumNames<DiffusionLossKind> = NamesOf<DiffusionLossKind>({{DiffusionLossKind::kMse, "mse"},
                                                                                  {DiffusionLossKind::kBce, "bce"}});

}  // namespace diffsac
