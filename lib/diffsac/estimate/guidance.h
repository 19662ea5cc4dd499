#pragma once

#include "diffsac/core/enum_names.h"

namespace diffsac {

/// Where minimal samples come from. Default: kNetwork, because a network finds models among few right matches that
/// PROSAC misses, and independent samples by it do as well as those of the diffusion model in less time
/// (docs/experiments.md).
///   kNone       "none": PROSAC by ratios or scores if there are any, else uniform samples. Vanishing points: those of
///               most length
///   kNetwork    "network": half by a network's inlier probabilities, half by PROSAC, for F, E and H. Vanishing points:
///               a network chooses them. Functions without such a network, and matches with scores: as kNone; so do
///               lines and planes, whose samples are too cheap for a network to pay
///   kDiffusion  "diffusion": the paper's method, for F, E, H, lines and planes: the γ most confident points of each of
///               κ = 20 samples of a reverse diffusion process. max_iterations sets κ, up to 1000. Functions without
///               such a network, and matches with scores, throw Error
/// Scores, refinement and all that a result says are the same for the three.
enum class Guidance {
  kNone,      ///< No network.
  kNetwork,   ///< A network's inlier probabilities. The default.
  kDiffusion  ///< The reverse diffusion process of the paper.
};
/// Their names.
template <>
inline constexpr auto kEnumNames<Guidance> = NamesOf<Guidance>({{Guidance::kNone, "none"},
                                                                {Guidance::kNetwork, "network"},
                                                                {Guidance::kDiffusion, "diffusion"}});

}  // namespace diffsac
