#pragma once

#include <array>
#include <cmath>

#include "lab/eval/results.h"

namespace diffsac {

/// The numbers of a record (ProblemRecord, const or not) by the names of their columns in problems.csv, in their order:
/// the one list for writing and reading that file and the lines of shards. visit(name, value): value is a double, a
/// count (int, std::int64_t), a bool, of VisitPose a Degeneracy, of VisitStructures a list of doubles.
template <class Record, class Visit>
void VisitRecord(Record& record, const Visit& visit) {
  visit("angle_deg", record.error.angle_deg);
  visit("offset", record.error.offset);
  visit("rotation_deg", record.error.rotation_deg);
  visit("translation_deg", record.error.translation_deg);
  visit("error_px", record.error.error_px);
  visit("focal_error", record.error.focal);
  visit("inliers", record.inliers);
  visit("hypotheses", record.stats.hypotheses);
  visit("ms_features", record.stats.ms_features);
  visit("ms_network", record.stats.ms_network);
  visit("ms_consensus", record.stats.ms_consensus);
  visit("ms_total", record.stats.ms_total);
  visit("points", record.points);
  visit("failed", record.error.failed);
  visit("unique_minimal_sets", record.stats.unique_minimal_sets);
  visit("all_inlier_sets", record.all_inlier_sets);
}

/// What was estimated, where the experiment keeps estimates: sigma, the pose (PoseNumbers) and the model. For writing.
template <class Visit>
void VisitEstimate(const EstimateRecord& record, const Visit& visit) {
  constexpr const char* kPose[] = {"qw", "qx", "qy", "qz", "tx", "ty", "tz"};
  visit("sigma", std::isfinite(record.sigma) ? record.sigma : std::nan(""));
  const std::array<double, 7> pose = PoseNumbers(record.pose);
  for (std::size_t i = 0; i < pose.size(); ++i) visit(kPose[i], pose[i]);
  visit("model", record.model);
}

/// Those behind the estimate's columns.
template <class Record, class Visit>
void VisitChance(Record& record, const Visit& visit) {
  visit("log10_nfa", record.log10_nfa);
}

/// What the problem itself is like.
template <class Record, class Visit>
void VisitQuantities(Record& record, const Visit& visit) {
  visit("inlier_share", record.inlier_share);
  visit("true_rotation_deg", record.true_rotation_deg);
  visit("true_baseline", record.true_baseline);
  visit("true_parallax_deg", record.true_parallax_deg);
}

/// What the estimate's covariance is worth.
template <class Record, class Visit>
void VisitLevels(Record& record, const Visit& visit) {
  visit("rotation_level", record.levels.rotation);
  visit("translation_level", record.levels.translation);
}

/// Of two views: what a person is given and told.
template <class Record, class Visit>
void VisitPose(Record& record, const Visit& visit) {
  visit("pose_rotation_deg", record.error.pose_rotation_deg);
  visit("pose_translation_deg", record.error.pose_translation_deg);
  visit("pose_deg", record.error.pose_deg);
  visit("degeneracy", record.degeneracy);
  visit("has_ambiguous_pose", record.has_ambiguous_pose);
  visit("error_probability", record.error_probability);
}

/// Those of several structures, which problems.csv has where these are judged.
template <class Record, class Visit>
void VisitInstances(Record& record, const Visit& visit) {
  visit("misclassified", record.error.misclassified);
  visit("recall", record.error.recall);
  visit("one_structure_sets", record.one_instance_sets);
  visit("structures_in_sets", record.instances_in_sets);
  visit("structures", record.instance_count);
  visit("draws", record.stats.iterations);
  visit("structure_angles_deg", record.error.instance_angles_deg);
}

/// All of them, in the order of problems.csv but for what it has of the estimate, which shards have in estimates.h5.
template <class Record, class Visit>
void VisitAll(Record& record, const Visit& visit) {
  VisitRecord(record, visit);
  VisitChance(record, visit);
  VisitQuantities(record, visit);
  VisitLevels(record, visit);
  VisitPose(record, visit);
  VisitInstances(record, visit);
}

}  // namespace diffsac
