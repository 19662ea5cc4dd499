#pragma once

#include <Eigen/Core>
#include <optional>

#include "diffsac/core/random.h"
#include "diffsac/problem/image_pair.h"
#include "diffsac/problem/problem.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/options/options.h"

namespace diffsac {

/// A pinhole camera without lens distortion. Pixel (0, 0) is a corner of the image, (width, height) the opposite one.
struct VirtualCamera {
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  ImageSize size;
  /// Whether a pixel lies inside the image.
  bool Contains(const Eigen::Vector2d& pixel) const;
  /// The ray through a pixel, with depth 1.
  Eigen::Vector3d Ray(const Eigen::Vector2d& pixel) const;
  /// Uniform over the image.
  Eigen::Vector2d RandomPixel(Rng& rng) const;
};

/// Two of them: `motion` takes coordinates of the first to the second.
struct VirtualPair {
  VirtualCamera first, second;
  RigidMotion motion;
};

/// The exact correspondence x1 y1 x2 y2 of a point in the first camera's coordinates. False unless it lies before both
/// cameras (depth above `least_depth`) and inside both images.
bool ProjectIntoBoth(const VirtualPair& pair, const Eigen::Vector3d& point, double least_depth, Eigen::Vector4d* match);

/// How random cameras look.
struct VirtualCameraOptions {
  Range image_width = {600, 2000};  ///< pixels
  Range image_aspect = {0.5, 1.4};  ///< height over width
  Range focal = {0.6, 1.8};         ///< focal length over the longer side; square pixels
  double principal_offset = 0.03;
  double same_camera = 0.7;  ///< probability that both images come from one camera
  void Bind(OptionsBinder& b);
};
VirtualCamera RandomCamera(const VirtualCameraOptions& options, Rng rng);
/// The second camera of a pair whose first is `first`.
VirtualCamera RandomSecondCamera(const VirtualCameraOptions& options, const VirtualCamera& first, Rng rng);

/// Uniform on the sphere.
Eigen::Vector3d RandomDirection(Rng& rng);
/// A unit vector at `degrees` from the unit vector `axis`, at a random azimuth.
Eigen::Vector3d Tilted(const Eigen::Vector3d& axis, double degrees, Rng& rng);
/// By `degrees` about a random axis.
Eigen::Matrix3d RandomRotation(double degrees, Rng& rng);
/// The range is drawn from uniformly in the logarithm; both ends positive.
double LogUniform(const Range& range, Rng& rng);

/// Points nearer than this (in a scene's unit, its nearest depth) are not seen.
inline constexpr double kLeastDepth = 0.1;

/// The plane normal · X = distance with distance > 0 in the first camera's coordinates.
struct VirtualPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double distance = 1.0;

  /// x2 ~ H x1 in pixels.
  Eigen::Matrix3d Homography(const VirtualPair& pair) const;
  /// Whether camera 2 is on the same side of the plane as camera 1, and not too near.
  bool FacesBoth(const RigidMotion& motion) const;
  /// The exact correspondence of the plane's point that `pixel` of image 1 shows. False unless ProjectIntoBoth, and
  /// where its depth is less than half of the nearest or more than twice the farthest of `depths`.
  bool Match(const VirtualPair& pair, const Range& depths, const Eigen::Vector2d& pixel, Eigen::Vector4d* match) const;
};

/// The motion to a second camera at `centre2`. It is turned by `turn` after it was turned towards the point of the
/// first camera's axis at depth `towards`, where that is given.
RigidMotion MotionTo(const Eigen::Vector3d& centre2, const Eigen::Matrix3d& turn, std::optional<double> towards);

}  // namespace diffsac
