#pragma once

#include <vector>

#include "diffsac/core/enum_names.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// Which matches stay where there are too many: those of the best ratio (the first where there is none), or random
/// ones.
enum class PointCap { kBest, kRandom };
template <>
inline constexpr auto kEnumNames<PointCap> = NamesOf<PointCap>({{PointCap::kBest, "best"},
                                                                {PointCap::kRandom, "random"}});

/// Which matches of a pair are used, in which order, and how good their descriptors are.
struct PairFilter {
  bool ratios = true;
  bool scale_rotation_changes = true;
  double max_ratio = 1.0;
  int max_points = 0;
  PointCap cap = PointCap::kBest;
  bool shuffle_points = false;
  double descriptor_noise = 0.0;
};

/// The rows to keep, in their order or, when they are shuffled, in a random one.
std::vector<int> KeptRows(const Example& pair, const PairFilter& filter);

/// The pair as the filter leaves it: points, ratios, descriptors, inliers and labels of the kept matches.
Example Filtered(const Example& pair, const PairFilter& filter);

/// The example with these of its points alone, in this order, and all that belongs to them. Structures stay, also those
/// without points (ArrangeStructures in lab/data/instance_sizes.h drops them).
Example WithRows(const Example& example, const std::vector<int>& rows);

}  // namespace diffsac
