#pragma once

#include <Eigen/Core>
#include <optional>

#include "diffsac/problem/image_pair.h"
#include "lab/colmap/lens.h"

namespace diffsac {

/// A pinhole camera behind a lens with radial and tangential distortion (Brown, "Close-range camera calibration",
/// 1971), or behind another of COLMAP's. Pixel centres have whole coordinates: the first one is (0, 0).
struct LensCamera {
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0;
  ImageSize size;                           ///< Zero when the source gives none.
  std::optional<ColmapLens> lens = {};      ///< In place of k1 to p2: fisheyes and others that these do not describe.
  std::optional<ColmapCamera> colmap = {};  ///< As COLMAP has it, where it comes from there.

  /// Whether the lens bends nothing.
  bool IsStraight() const;
  /// From where a pixel is seen to where it would be seen without distortion, and back. NaN where no camera without
  /// distortion could see it (ColmapLens::Undistort).
  Eigen::Vector2d Undistort(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d Distort(const Eigen::Vector2d& pixel) const;
};

}  // namespace diffsac
