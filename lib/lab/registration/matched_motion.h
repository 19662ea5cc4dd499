#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "diffsac/diffsac.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {

/// What matches say of the motion between two clouds.
struct MatchedMotion {
  Task task = Task::kRigid;  ///< kRigid or kSimilarity.
  int matches = 0;
  /// Of a similarity too, without its scale; its covariance is 7 × 7 then, (ω, t, log s).
  RigidMotionEstimate estimate;
  double scale = 1.0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< Of the inliers, in the first cloud.
};

/// How sure a motion is: of its t, which far from the clouds hangs on R, and where the clouds are.
struct MotionSpread {
  Eigen::MatrixXd of_t;       ///< Covariance of (ω, t), with a scale (ω, t, log s), of the motion as it is told.
  Eigen::MatrixXd of_middle;  ///< The same with the place that the middle moves to for t.
  Eigen::Vector3d middle;     ///< Of the inliers, in the first file's frame.
};

/// EstimateRigidMotion or EstimateSimilarity.
MatchedMotion EstimateMatched(Task task, const Matches3D3D& matches, const RegistrationOptions& options);

/// `motion`: between the files' frames; `origin`: where in the first file's frame the estimate's one is. Absent without
/// a covariance.
std::optional<MotionSpread> SpreadOf(const MatchedMotion& found, const RigidMotion& motion,
                                     const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

/// For a terminal: how many inliers, R, t (and s), deviations; or why there is none. Arguments as those of SpreadOf.
std::string MotionText(const MatchedMotion& found, const RigidMotion& motion,
                       const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

/// The same, with what may be wrong with it, for one JSON object.
nlohmann::ordered_json MotionJson(const MatchedMotion& found, const RigidMotion& motion,
                                  const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

/// That with the file's name and the rows of the inliers, from 0.
std::string MatchedJson(const std::string& file, const MatchedMotion& found);

/// Several motions in the same matches, each with its number of matches.
std::string MotionsText(const MultiModelEstimate<Eigen::Matrix<double, 3, 4>>& found);
/// The same, with the number of the motion of each match, 0 for none.
std::string MotionsJson(const std::string& file, const MultiModelEstimate<Eigen::Matrix<double, 3, 4>>& found);

}  // namespace diffsac
