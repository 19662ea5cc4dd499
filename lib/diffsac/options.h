#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "diffsac/estimate/cameras.h"
#include "diffsac/estimate/guidance.h"
#include "diffsac/geometry/focal.h"
#include "diffsac/problem/image_pair.h"

// Options of the functions in diffsac.h: aggregates for designated initialisers,
// `{.max_residual = 2.0, .confidence = 0.9999, .seed = 7}`. An absent value is the recommended one.
namespace diffsac {

/// Options for two-view and absolute-pose estimation.
struct ImageOptions {
  /// Inlier threshold in pixels (E, F: Sampson error; H: transfer error; poses: reprojection error). Default: 1 (E, F),
  /// 3 (H), 4 (absolute poses). If the median point is not 20 to 20000 from the origin (coordinates from 0 to 1,
  /// normalised, film), one pixel is taken as 0.1 % of the extent of the points. E, F and H estimate the noise
  /// themselves, at scales about this value; it also caps the residual of an inlier.
  std::optional<double> max_residual = {};
  /// Maximum number of minimal samples. Default: 1000. The search stops earlier when it is confident.
  std::optional<int> max_iterations = {};
  std::optional<int> min_iterations = {};  ///< Minimum number of minimal samples. Default: 100; absolute poses: 0.
  /// Stops when a better model would have been sampled with this probability. Default: 0.9999. Not used for multiple
  /// models, which draw all max_iterations samples.
  std::optional<double> confidence = {};
  int num_threads = 1;  ///< Threads of one call; 0: one for each core. Results do not depend on it.
  /// A hypothesis to score in addition to the sampled ones, in the shape of the result's `model`.
  std::optional<Eigen::MatrixXd> initial_model = {};
  /// What guides the samples of E, F and H. Matches with scores and absolute poses use no network.
  Guidance guidance = Guidance::kNetwork;
  std::string models_folder = {};  ///< A folder of networks to use instead of the library's.
  /// F: what is known of the cameras if the images' sizes are given and equal. A camera that the matches
  /// contradict (a crop, two zooms) is not used.
  Cameras cameras = Cameras::kPhotographs;
  std::optional<FocalPrior> prior = {};   ///< F of photographs: as FocalOptions'.
  std::optional<FocalPrior> prior2 = {};  ///< F of photographs: of the second image. Default: `prior`.
  std::uint64_t seed = 0;                 ///< Seed of the random samples.
};

/// Options for lines and planes.
struct PointOptions {
  std::optional<double> max_residual = {};            ///< Required: maximum distance of an inlier, in the points' unit.
  std::optional<int> max_iterations = {};             ///< As ImageOptions'. Default: 420.
  std::optional<int> min_iterations = {};             ///< As ImageOptions'. Default: 50.
  std::optional<double> confidence = {};              ///< As ImageOptions'.
  int num_threads = 1;                                ///< As ImageOptions'.
  std::optional<Eigen::MatrixXd> initial_model = {};  ///< As ImageOptions'.
  Guidance guidance = Guidance::kNetwork;             ///< As ImageOptions'.
  std::string models_folder = {};                     ///< As ImageOptions'.
  std::uint64_t seed = 0;                             ///< As ImageOptions'.
};

/// Options for the registration of two clouds by matches.
struct RegistrationOptions {
  /// Maximum distance of an inlier, in the second cloud's unit. The noise is estimated, from a quarter of this to 1.5
  /// times this. Default: twice the resolution of the second cloud's matched points (median distance to the nearest
  /// other one), which suits clouds that were downsampled to that resolution. Give it if few points are matched.
  std::optional<double> max_residual = {};
  std::optional<int> max_iterations = {};             ///< As ImageOptions'. Default: 10000.
  std::optional<int> min_iterations = {};             ///< As ImageOptions'. Default: 100.
  std::optional<double> confidence = {};              ///< As ImageOptions'.
  int num_threads = 1;                                ///< As ImageOptions'.
  std::optional<Eigen::MatrixXd> initial_model = {};  ///< As ImageOptions'.
  std::uint64_t seed = 0;                             ///< As ImageOptions'.
};

/// Options for two views of unknown focal length.
struct FocalOptions {
  std::optional<double> max_residual = {};  ///< As ImageOptions'. Default: 1 px.
  /// Principal point of the first image, in pixels. Default: the centre of Matches::size1.
  std::optional<Eigen::Vector2d> principal_point1 = {};
  std::optional<Eigen::Vector2d> principal_point2 = {};  ///< The same of the second image.
  /// Likeliest focal length in pixels and the standard deviation of its logarithm (EXIF: 0.1). Default: that of cameras
  /// in general, which needs the images' sizes.
  std::optional<FocalPrior> prior = {};
  std::optional<FocalPrior> prior2 = {};   ///< EstimateTwoFocals: of the second image. Default: `prior`.
  std::optional<int> max_iterations = {};  ///< As ImageOptions'.
  std::optional<int> min_iterations = {};  ///< As ImageOptions'.
  std::optional<double> confidence = {};   ///< As ImageOptions'.
  int num_threads = 1;                     ///< As ImageOptions'.
  std::uint64_t seed = 0;                  ///< As ImageOptions'.
};

/// Options for vanishing points.
struct VanishingPointOptions {
  /// Calibration matrix of the image, without lens distortion. If absent, the focal length is estimated, about the
  /// image's centre.
  std::optional<Eigen::Matrix3d> K = {};
  ImageSize size = {};  ///< Size of the image in pixels. Required if `K` is absent.
  /// Maximum angle in degrees between a segment and the direction to its vanishing point.
  double max_residual_deg = 2.0;
  /// The list ends before the first vanishing point for which the network's probability is lower, in [0, 1]; 0: eight.
  double least_value = 0.35;
  std::optional<int> max_iterations = {};  ///< Number of minimal samples. Default: 1500; 1000 without a network.
  Guidance guidance = Guidance::kNetwork;  ///< kNone: chosen by the length of their segments instead of a network.
  std::string models_folder = {};          ///< As ImageOptions'.
  std::uint64_t seed = 0;                  ///< As ImageOptions'.
};

}  // namespace diffsac
