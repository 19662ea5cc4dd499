#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

struct ExperimentResults;

/// The file of a run folder that holds what was estimated (docs/estimates.md).
inline constexpr const char* kEstimatesFile = "estimates.h5";

/// What one method said of one problem, as estimates.h5 has it.
struct EstimateRecord {
  std::uint64_t index = 0;  ///< The problem's place in its condition's data.
  std::string id;
  std::string scene;
  Status status = Status::kNoModel;
  ModelParameters model;                           ///< Empty unless status is ok; E in normalised coordinates.
  std::optional<RigidMotion> pose;                 ///< Where the model has one (PoseOfEstimate).
  std::optional<Eigen::MatrixXd> pose_covariance;  ///< As in Estimate.
  Degeneracy degeneracy = Degeneracy::kNotTested;  ///< As in Estimate; t of `pose` is zero where it is not determined.
  std::optional<RigidMotion> ambiguous_pose;       ///< As in Estimate.
  double cheirality_failure_ratio = 0.0;           ///< As in Estimate.
  std::optional<FocalEstimate> focal;
  std::vector<std::int32_t> inlier_rows;  ///< Of the problem's points, ascending.
  /// What an inlier is, in the data's unit, as in Estimate; NaN without a model.
  double inlier_threshold = std::numeric_limits<double>::quiet_NaN();
  int points = 0;  ///< Of the problem.
  /// Of points of a file of which some are left out (PointSource): the file's rows that the problem has; else empty.
  std::vector<std::int32_t> rows;
  /// The farthest that a point is from zero along an axis: how many digits of a model matter. NaN: not known.
  double largest_coordinate = std::numeric_limits<double>::quiet_NaN();
  double score = 0.0;
  double sigma = std::numeric_limits<double>::quiet_NaN();      ///< σ, in the data's unit; NaN: not estimated.
  double log10_nfa = std::numeric_limits<double>::quiet_NaN();  ///< As in Estimate.
  bool MayBeChance() const { return log10_nfa > 0.0; }
  std::int64_t draws = 0;                   ///< Minimal sets drawn; 0 for methods that do not tell.
  std::vector<float> inlier_probabilities;  ///< N values where a network gave some, else empty.
  /// Of rows that look for several structures: as in Estimate.
  std::vector<ModelParameters> instances;
  std::vector<std::int32_t> assignment;
  std::vector<double> instance_values;
};

/// `whole`: false where what was found is not kept: it is left out, but for its status, inliers' number, draws and what
/// is said of the translation.
EstimateRecord RecordOf(const Example& example, const Estimate& estimate, bool whole = true);

/// qw, qx, qy, qz, tx, ty, tz: x2 = R x1 + t with R as a unit quaternion, qw >= 0. NaN without a pose, and of a
/// translation of zero, which is one that is not determined.
std::array<double, 7> PoseNumbers(const std::optional<RigidMotion>& pose);

/// Writes the file into the run's folder, whole or not at all: the records of all problems, or, where the experiment
/// keeps no estimates, of the kept examples; and these examples. An earlier run's goes where there is nothing to write.
/// Throws Error.
void WriteEstimates(const ExperimentResults& results, const std::string& folder);

}  // namespace diffsac
