#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/rows_view.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// The value that so large a share of those that are finite is below; 0 without any.
double Quantile(const Eigen::VectorXd& values, double share);

/// A thousandth of how far an image's points (N × 2) go, twice the range of their middle half: about a pixel of usual
/// photographs, in whatever unit the points are. Rows that are not finite do not count; 0 without others, or where all
/// are alike.
double ShareOfExtent(const Points2DView& points);

/// How long a pixel is in the unit of the points: 1 where the median point is 20 to 20000 from the origin by its larger
/// coordinate, as pixels of photographs are; else (coordinates from 0 to 1, normalised or in millimetres, film at its
/// full resolution) ShareOfExtent, or 1 where that is 0.
double PixelLength(const Points2DView& points);

/// One of the two lengths, of two images in unlike units: residuals of E are of both, by their mean focal length,
/// others in the smaller unit.
double LengthInResiduals(Task task, const Points2DView& points1, const Points2DView& points2,
                         double (*length_of)(const Points2DView&));

}  // namespace diffsac
