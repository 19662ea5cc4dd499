#pragma once

#include <nlohmann/json_fwd.hpp>
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
};

/// EstimateRigidMotion or EstimateSimilarity.
MatchedMotion EstimateMatched(Task task, const CloudMatches& matches, const CloudOptions& options);

/// For a terminal: how many inliers, R, t (and s), deviations; or why there is none. `motion`: between the files'
/// frames.
std::string MotionText(const MatchedMotion& found, const RigidMotion& motion);

/// The same, with what may be wrong with it, for one JSON object.
nlohmann::ordered_json MotionJson(const MatchedMotion& found, const RigidMotion& motion);

/// That with the file's name and the rows of the inliers, from 0.
std::string MatchedJson(const std::string& file, const MatchedMotion& found);

/// Several motions in the same matches, each with its number of matches.
std::string MotionsText(const ModelsEstimate<Eigen::Matrix<double, 3, 4>>& found);
/// The same, with the number of the motion of each match, 0 for none.
std::string MotionsJson(const std::string& file, const ModelsEstimate<Eigen::Matrix<double, 3, 4>>& found);

}  // namespace diffsac
