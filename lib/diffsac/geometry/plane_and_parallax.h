#pragma once

#include <Eigen/Core>

#include "diffsac/core/random.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {

// Epipolar geometry where most points lie on one plane (Chum, Werner, Matas, "Two-view geometry estimation unaffected
// by a dominant plane", CVPR 2005: DEGENSAC). Such points fix F = [e2]ₓ H up to the epipole e2 alone: a minimal set of
// mostly coplanar points fits the whole plane, whatever e2 its noise or its outliers chose. The plane's H is right,
// though, and two points off the plane give e2: each says that e2 lies on the line from H x1 to x2.

/// The homography of the plane through three correspondences, given F: H = [e2]ₓ F − e2 (M⁻¹ b)ᵀ (Hartley and
/// Zisserman, result 13.6). `points` holds rows x1 y1 x2 y2 of order one. False when the three points are (almost)
/// collinear or repeated in either image, or one of them is the epipole.
bool PlaneHomography(const Eigen::Matrix3d& f, const double (*points)[4], const int triplet[3], Eigen::Matrix3d* h);

/// Of a set of 7 or 8 correspondences (`size`) that `f` was solved from: the homography that all but two of them or
/// more agree with, from the five triplets {1,2,3}, {4,5,6}, {1,2,7}, {4,5,7}, {3,6,7}, of which every such majority
/// holds one whole. `threshold` is on SymmetricTransferError, in the unit of `points`. False when there is none: the
/// set is not degenerate.
bool FindPlaneInSet(const Eigen::Matrix3d& f, const double (*points)[4], int size, double threshold,
                    Eigen::Matrix3d* h);

/// F = [e2]ₓ H, where e2 is on the lines of two correspondences off the plane. False when the lines coincide, a point
/// is on the plane, or a point is turned against the oriented epipolar constraint (H being signed with w > 0).
bool FundamentalFromPlaneAndParallax(const Eigen::Matrix3d& h, const double* first, const double* second,
                                     Eigen::Matrix3d* f);

/// Fundamental::RecoverFromDegeneracy for sets of `size` (7 or 8) points; without a set (null), of random inliers.
/// Where the set is degenerate: fits the plane's H to all points within √3 `threshold` of it (transfer errors have
/// twice the freedom of Sampson distances), draws pairs of points off the plane (a bounded number, all of them where
/// they are few), takes the F that most other points off the plane support by truncated Sampson distance, and refines
/// it on all points by Levenberg-Marquardt, which keeps the epipole where a linear fit would give it to the plane's
/// noise. Writes at most `max_models` models: the refined one, then the one drawn. 0 when nothing but the pair itself
/// supports any epipole, as for a scene that is one plane.
int RecoverFromPlane(const PointMatrix& points, const int* set, int size, const Matrix3Parameters& model,
                     double threshold, Rng rng, int max_models, Matrix3Parameters* out, int* fits);

}  // namespace diffsac
