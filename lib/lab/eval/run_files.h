#pragma once

#include <string>

#include "lab/eval/report.h"

namespace diffsac {

/// results.csv, long: experiment,dataset,scene,condition,method,metric,value. Unknown values are empty. Strata stand in
/// the scene's place, effects and comparisons in the method's.
std::string ResultsCsv(const Report& report);

/// problems.csv: id,scene,condition,method,status,angle_deg,offset,rotation_deg,translation_deg,error_px,focal_error,
/// inliers,hypotheses,ms_features,ms_network,ms_consensus,ms_total,points,failed,unique_minimal_sets,all_inlier_sets,
/// and where the experiment keeps estimates sigma,qw,qx,qy,qz,tx,ty,tz,model: σ, the pose x2 = R x1 + t
/// (docs/estimates.md), R as a unit quaternion, qw ≥ 0, and the model's parameters, blanks between them; then
/// log10_nfa, what is known of the problem (problem_quantities.h), rotation_level and translation_level
/// (PoseLevels); of two views pose_rotation_deg,pose_translation_deg,pose_deg (AddPoseError), translation and
/// has_ambiguous_pose (1: Estimate::ambiguous_pose is there), error_probability. Unknown values are empty.
std::string ProblemsCsv(const ExperimentResults& results);

/// Markdown with aligned columns, ready to read on a terminal.
std::string MarkdownTable(const Table& table);

/// How the results were measured, in a line: problems, conditions, seed.
std::string ReportSetting(const ExperimentResults& results);

/// What the tables' columns mean.
std::string ReportNotes(const Report& report);

/// The whole table.md: title, how it was measured, the tables, notes.
std::string MarkdownReport(const Report& report);

/// results.json: what was run, for each method and condition the metrics of every scene, the bootstrap interval of mAA
/// and that of the reference method's mAA minus its own, the experiment's comparisons, and whatever else scripts/report
/// tells: the tables as they are printed, effects and strata as numbers, what pictures are asked for. Unknown values
/// are null. `config`: the run's config.yaml, whose first lines say by what, where and when it was run.
std::string ResultsJson(const Report& report, const std::string& config = "");

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

/// What a run of diffsac_eval left in its folder, from config.yaml, results.json and problems.csv, with the digits of
/// that file: records and what was left out, without pictures and estimates. A problem's index is its place among all
/// that the file names of its condition. Throws Error, naming file and line, for a folder without a run, a shard's, and
/// damaged files.
ExperimentResults ReadRun(const std::string& folder);

/// One line that says where a run's results are: the folder, and what of it a person opens or reads first.
std::string ResultsText(const std::string& folder);

}  // namespace diffsac
