#pragma once

#include "diffsac/geometry/homography.h"
#include "diffsac/problem/chance_share.h"
#include "diffsac/problem/two_view_task.h"

namespace diffsac {

template <>
inline constexpr const char* kModelName<Homography> = "homography";

/// A plane in two views.
struct HomographyTask : TwoViewTask<Homography> {
  static double ChanceShare(const Problem& problem, double threshold) {
    return DiscShare(ImageExtent(problem.size2, problem.points.rightCols(2)), threshold);
  }
};

}  // namespace diffsac
