#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/problem/problem.h"

namespace diffsac {

/// What only labels, metrics and the oracle may see; each part is empty where it is unknown.
struct GroundTruth {
  // What estimates of the problem's task are measured against.
  ModelParameters model;                  ///< Of the task. E in normalised coordinates.
  std::optional<RelativePose> pose = {};  ///< Two views: of the second camera seen from the first; |t| = 1, or t = 0.
  std::vector<std::uint8_t> inliers;      ///< N values, 1 for a true inlier.
  /// Two views: the true calibration, where the task is to do without one (Problem::cameras is empty then).
  std::optional<CameraPair> cameras = {};

  /// Two clouds: an error of so much of the second cloud's unit counts like a degree, as benchmarks have it.
  double length_per_degree = 1.0;

  // What the source of a pair of images knows, whatever the task; SetTask (lab/ground_truth/pair_truth.h) makes the
  // above of it. Matrices act on homogeneous column vectors, scale and sign are arbitrary.
  std::optional<RigidMotion> motion = {};           ///< x_camera2 = R x_camera1 + t, t in the unit of the source.
  std::optional<Eigen::Matrix3d> essential = {};    ///< x2ᵀ E x1 = 0 in coordinates K⁻¹ x.
  std::optional<Eigen::Matrix3d> fundamental = {};  ///< x2ᵀ F x1 = 0 in pixels.
  std::optional<Eigen::Matrix3d> homography = {};   ///< x2 ~ H x1 in pixels.
  /// N values: 0 an outlier, k ≥ 1 an inlier of structure k (1 alone, or one number a plane).
  std::vector<std::int32_t> assignment = {};
  /// Where several models are true at once: structure k of `assignment` at place k − 1. Then `inliers` are those of any
  /// of them, and `model` is that of most points. Empty: one model, or none.
  std::vector<ModelParameters> instances = {};
};

/// One item of a dataset, or one pair of images of a scene.
struct Example {
  std::uint64_t index = 0;  ///< Position in the dataset.
  /// Unique in the dataset (or the scene that is read), stable. With the scene it decides what estimators draw.
  std::string id;
  /// PointDigest of points that were drawn, not read: by another seed or other options the same id is another problem.
  std::string digest;
  std::string scene;   ///< Group for per-scene means ("all" for synthetic data).
  std::string image1;  ///< Two views: the name of the first image; empty where there is none.
  std::string image2;  ///< Of the second.
  Problem problem;     ///< What estimators see.
  GroundTruth truth;   ///< What they do not.
};

/// Eight hexadecimal digits that differ where points do.
std::string PointDigest(const PointMatrix& points);

/// What a problem is called in results: its id, with its digest where it has one. Results of problems of the same scene
/// and name can be compared.
std::string ProblemName(const Example& example);

/// A finite or endless (size() < 0) random-access source of examples. `Get` is thread-safe and depends on index alone.
class Dataset {
 public:
  virtual ~Dataset() = default;
  /// Of all its examples.
  virtual Task task() const = 0;
  /// How many there are, below 0 without an end.
  virtual std::int64_t size() const = 0;
  /// The example of a place, from 0.
  virtual Example Get(std::uint64_t index) const = 0;
  /// Where the files of a scene are; empty for data that has none, and for other scenes.
  virtual std::string FolderOf(const std::string& scene) const;
};

}  // namespace diffsac
