#pragma once

#include <Eigen/Core>

namespace diffsac {

/// Whether it is a calibration matrix: finite, positive focal lengths, last row 0 0 1.
inline bool IsCalibration(const Eigen::Matrix3d& K) {
  return K.allFinite() && K(0, 0) > 0.0 && K(1, 1) > 0.0 && K.row(2) == Eigen::RowVector3d(0, 0, 1);
}

/// The focal length of cameras in general, in longer sides of the image: the middle of the central 68 % (.59 to 1.38,
/// so that log f has a standard deviation of .43) of 14 + 16 e^(.8 n) mm, n normal, over 36 mm, by which Hold-Geoffroy
/// and others ("A deep perceptual measure for lens and camera calibration", TPAMI 2023) draw the focal lengths of
/// photographs.
inline constexpr double kMedianFocal = 0.9;

}  // namespace diffsac
