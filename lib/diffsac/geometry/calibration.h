#pragma once

#include <Eigen/Core>
#include <string>

namespace diffsac {

/// Whether it is a calibration matrix: finite, fx s cx, 0 fy cy, 0 0 1 with fx and fy above 0.
inline bool IsCalibration(const Eigen::Matrix3d& K) {
  return K.allFinite() && K(0, 0) > 0.0 && K(1, 1) > 0.0 && K(1, 0) == 0.0 && K.row(2) == Eigen::RowVector3d(0, 0, 1);
}

/// The calibration matrix, its last row 0 0 1: of a matrix that is one times a number above 0 (the same camera), with
/// zeros up to rounding. Throws Error for another, "WHAT: expected a calibration matrix, ...", saying what is wrong
/// with it: the transpose, say, or an image whose y points up.
Eigen::Matrix3d CheckedCalibration(const Eigen::Matrix3d& K, const std::string& what);

/// The focal length of cameras in general, in longer sides of the image: the middle of the central 68 % (.59 to 1.38,
/// so that log f has a standard deviation of .43) of 14 + 16 e^(.8 n) mm, n normal, over 36 mm, by which Hold-Geoffroy
/// and others ("A deep perceptual measure for lens and camera calibration", TPAMI 2023) draw the focal lengths of
/// photographs.
inline constexpr double kMedianFocal = 0.9;

}  // namespace diffsac
