#pragma once

#include "diffsac/geometry/rows_view.h"

namespace diffsac {

/// The resolution of a cloud (N × 3), in its unit: the median distance of its places from the nearest other one. Points
/// that are far nearer to each other than the places are one place, so neither repeated rows nor a mass of matches that
/// end in one place (up to nine of ten) decide. The order of the rows does not count, nor do rows that are not finite;
/// 0 without two places.
double CloudResolution(const Points3DView& cloud);

}  // namespace diffsac
