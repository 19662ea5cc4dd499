#pragma once

#include <string>

namespace diffsac {

/// The options of ConsensusOptions that are chosen by name. Each function throws Error for a name it does not know.

enum class LocalOptimization { kNone, kInnerSamples, kReweighted, kGraphCut, kRefine };
/// "none", "lo_ransac", "irls", "gc_ransac", "lm".
LocalOptimization LocalOptimizationFromString(const std::string& name);

enum class Refit { kNone, kInliers, kIterated, kMixture, kReweighted };
/// "none", "inliers", "iterated", "em", "irls".
Refit RefitFromString(const std::string& name);

/// "none" is false, "lm" true.
bool FinalRefinementFromString(const std::string& name);

/// "budget" is false, "confidence" true.
bool StopsByConfidence(const std::string& name);

}  // namespace diffsac
