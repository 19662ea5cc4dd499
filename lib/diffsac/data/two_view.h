#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/data/image_pair.h"
#include "diffsac/geometry/points.h"

namespace diffsac {

/// A world-to-camera or camera-to-camera motion: x' = rotation · x + translation.
struct RigidMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  bool operator==(const RigidMotion&) const = default;
};

/// From camera 1 to camera 2, both given world-to-camera: R = R2 R1ᵀ, t = T2 − R T1.
RigidMotion RelativeMotion(const RigidMotion& camera1, const RigidMotion& camera2);

/// The inverse motion: camera-to-world from world-to-camera and back.
RigidMotion Inverse(const RigidMotion& motion);

/// What an estimator may see of one pair of images. It carries no ground truth: that is the guard against leaks.
struct TwoViewProblem {
  PointMatrix points;       ///< N × 4, pixels: x1 y1 x2 y2, without lens distortion. NaN and infinities are kept.
  Eigen::VectorXd quality;  ///< N ratios of nearest to second-nearest descriptor distance, lower is better; or empty.
  /// N × 2d, the descriptors of image 1, then those of image 2, in one row; empty when not asked for or unknown.
  DescriptorMatrix descriptors;
  bool calibrated = false;  ///< Whether K1 and K2 are known; both are the identity otherwise.
  Eigen::Matrix3d K1 = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d K2 = Eigen::Matrix3d::Identity();
  ImageSize size1, size2;
  double inlier_threshold_px = 1.0;  ///< Linear.
};

/// What only labels, metrics and the oracle may see; each part is empty where it is unknown. Models act on homogeneous
/// column vectors, scale and sign are arbitrary.
struct TwoViewTruth {
  std::optional<RigidMotion> motion;           ///< x_camera2 = R x_camera1 + t, t in the unit of the source.
  std::optional<Eigen::Matrix3d> essential;    ///< x2ᵀ E x1 = 0 in coordinates K⁻¹ x.
  std::optional<Eigen::Matrix3d> fundamental;  ///< x2ᵀ F x1 = 0 in pixels.
  std::optional<Eigen::Matrix3d> homography;   ///< x2 ~ H x1 in pixels.
  /// N values: 0 an outlier, k ≥ 1 an inlier of structure k (1 alone, or one number a plane). Empty when unknown.
  std::vector<std::int32_t> labels;
};

/// One pair of images with its correspondences.
struct TwoViewExample {
  std::string id;              ///< "img1-img2", unique in the scene.
  std::string scene;           ///< Group for per-scene means.
  std::string image1, image2;  ///< The two halves of the id; empty when it has another form.
  TwoViewProblem problem;
  TwoViewTruth truth;
};

/// E = [t]× R.
Eigen::Matrix3d EssentialFromMotion(const RigidMotion& motion);

/// Fills E and F from what is there: E from the motion or from F and the calibration, F from E and the calibration.
/// What is already known stays.
void CompleteTruth(const TwoViewProblem& problem, TwoViewTruth* truth);

/// The distance in pixels of each correspondence from the true model: the transfer error |H x1 − x2| where a homography
/// is known, else the Sampson distance to F; empty when neither is known. Infinite where it is not a number.
Eigen::VectorXd TruthDistances(const TwoViewProblem& problem, const TwoViewTruth& truth);

}  // namespace diffsac
