#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

#include "diffsac/problem/image_pair.h"
#include "lab/colmap/database.h"

namespace diffsac {

/// "SIMPLE_RADIAL", ..., by COLMAP's number; none for a model that COLMAP 3.8 does not have.
std::optional<std::string> ColmapModelName(int model);
/// And back.
std::optional<int> ColmapModelNumber(std::string_view name);
/// How many parameters a camera model has; 0 for a model that there is not.
int ColmapParameterCount(int model);

/// A camera of COLMAP's as a pinhole camera behind a lens, for all eleven models of COLMAP 3.8: SIMPLE_PINHOLE,
/// PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE, FULL_OPENCV, FOV, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE,
/// THIN_PRISM_FISHEYE. Pixels are ours: the centre of the first one is (0, 0).
class ColmapLens {
 public:
  /// Throws Error, starting with `place`, for another model, too few or too many parameters, focal lengths that are not
  /// positive and values that are not finite.
  ColmapLens(const ColmapCamera& camera, const std::string& place);

  const Eigen::Matrix3d& K() const { return K_; }
  /// Whether the lens bends nothing.
  bool IsStraight() const { return straight_; }

  /// From where a pixel is seen to where a camera without distortion, of the same K, would see it. Nothing where no
  /// such camera could: a fisheye's rays beyond 90°, pixels that the distortion reaches from nowhere.
  std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& pixel) const;
  /// And back.
  Eigen::Vector2d Distort(const Eigen::Vector2d& pixel) const;

 private:
  Eigen::Vector2d DistortNormalized(const Eigen::Vector2d& point) const;

  int model_;
  Eigen::Matrix3d K_;
  double extra_[8] = {};  // the parameters behind focal lengths and centre
  bool straight_ = true;  // all of them are zero
};

/// A pinhole camera, behind one of COLMAP's lenses where it has one. Pixel centres have whole coordinates: the first
/// one is (0, 0).
struct LensCamera {
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  ImageSize size;  ///< Zero when the source gives none.
  std::optional<ColmapLens> lens = {};
  std::optional<ColmapCamera> colmap = {};  ///< As COLMAP has it, where it comes from there.

  /// Whether the lens bends nothing.
  bool IsStraight() const { return !lens || lens->IsStraight(); }
  /// From where a pixel is seen to where it would be seen without distortion, and back. NaN where no camera without
  /// distortion could see it (ColmapLens::Undistort).
  Eigen::Vector2d Undistort(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d Distort(const Eigen::Vector2d& pixel) const { return lens ? lens->Distort(pixel) : pixel; }
};

/// A camera of COLMAP's. Throws Error as ColmapLens does.
LensCamera CameraOfColmap(const ColmapCamera& camera, const std::string& place);

}  // namespace diffsac
