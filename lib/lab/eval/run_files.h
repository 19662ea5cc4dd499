#pragma once

#include <string>

#include "lab/eval/report.h"

namespace diffsac {

/// results.csv, long: experiment,dataset,scene,condition,method,metric,value. Unknown values are empty. Strata stand in
/// the scene's place, effects and comparisons in the method's (long_lines.h).
std::string ResultsCsv(const Report& report);

/// problems.csv: id,scene,condition,method,status,angle_deg,offset,rotation_deg,translation_deg,error_px,focal_error,
/// inliers,hypotheses,ms_features,ms_network,ms_consensus,ms_total,points,failed,unique_minimal_sets,all_inlier_sets,
/// and where the experiment keeps estimates noise_scale,qw,qx,qy,qz,tx,ty,tz,model: σ, the pose x2 = R x1 + t
/// (docs/estimates.md), R as a unit quaternion, qw ≥ 0, and the model's parameters, blanks between them; then
/// log_false_alarms, what is known of the problem (problem_quantities.h), rotation_level and translation_level
/// (lab/eval/pose_levels.h). Unknown values are empty.
std::string ProblemsCsv(const ExperimentResults& results);

/// Writes results.csv, problems.csv, reliability.csv where there is something to tell, and table.md into a folder, each
/// file whole or not at all. Throws Error.
void WriteResults(const Report& report, const std::string& folder);

/// A folder holds the run that its config.yaml names when results.json is there: it is removed before anything else is
/// written, so that an earlier run's does not pass for this one's, and written when all else is there. Throws Error.
void BeginResults(const std::string& folder);
void EndResults(const Report& report, const std::string& folder);

/// Whether a folder holds what running the experiment would give: the whole results of the same configuration, newer
/// than this program and than the networks that rows name.
bool IsMade(const ExperimentOptions& experiment, const std::string& folder);

}  // namespace diffsac
