#pragma once

#include <Eigen/Core>

namespace diffsac {

/// How long a pixel is, or what stands for one, in the unit of an image's points, N × 2: 1 where the median point is 20
/// to 20000 from the origin by its larger coordinate, as pixels of photographs are; else (coordinates from 0 to 1,
/// normalised or in millimetres, film at its full resolution) a thousandth of how far the points go, twice the range of
/// their middle half. Rows that are not finite do not count; 1 without others, or where they are all alike.
double PixelLength(const Eigen::Matrix<double, Eigen::Dynamic, 2>& points);

}  // namespace diffsac
