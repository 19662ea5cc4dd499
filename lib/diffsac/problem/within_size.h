#pragma once

#include <string>

#include "diffsac/geometry/rows_view.h"
#include "diffsac/problem/image_pair.h"

namespace diffsac {

/// Throws Error where more than 15 % of an image's points (N × 2, pixels), and more than two, lie outside its size:
/// the size is another image's then, or (height, width). Some always may: lenses are taken out, matches are stray. So a
/// fiftieth of the longer side and two pixels do not count, nor do rows that are not finite. The message names the
/// size by `name`, how many there are and the first one. An unknown size holds all.
void RequireWithin(const ImageSize& size, const Points2DView& points, const std::string& name);

}  // namespace diffsac
