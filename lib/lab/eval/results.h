#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/eval/bootstrap.h"
#include "lab/eval/estimates.h"
#include "lab/eval/experiment.h"
#include "lab/eval/metrics.h"
#include "lab/eval/reliability.h"

namespace diffsac {

/// Two views, how far an estimate is from the truth by its own covariance: the confidence, in [0, 1], of the smallest
/// region about R (t's direction) that holds the true one. A 68 % region holds the truth where it is .68 at most.
/// Covariances that say what is so give every confidence equally often.
struct PoseLevels {
  double rotation = std::numeric_limits<double>::quiet_NaN();
  double translation = std::numeric_limits<double>::quiet_NaN();  ///< NaN of cameras in one place.
};

/// One method on one problem: the estimate (whole where the experiment keeps estimates) and what the truth says of it.
/// What files have of it is listed once, in record_fields.h and, of estimates.h5, in estimates.cpp.
struct ProblemRecord : EstimateRecord {
  std::string scene;  ///< Its group (ExperimentOptions::scene_groups) where it has one.
  EstimateError error;
  int inliers = 0;    ///< How many.
  PoseLevels levels;  ///< By the estimate's own covariance.
  /// Two views: whether another pose explains the inliers as well (Estimate::ambiguous_pose).
  bool has_ambiguous_pose = false;
  double error_probability = std::numeric_limits<double>::quiet_NaN();  ///< Estimate::error_probability.
  /// Share of the first (up to 20) minimal sets that hold true inliers alone; NaN without sets or true inliers.
  double all_inlier_sets = std::numeric_limits<double>::quiet_NaN();
  /// Several structures, of the same sets: the share whose points are all of one true structure, and the share of the
  /// true structures that at least one such set is of; else NaN.
  double one_instance_sets = std::numeric_limits<double>::quiet_NaN();
  double instances_in_sets = std::numeric_limits<double>::quiet_NaN();
  /// Of the problem, not of its estimate; NaN where it is unknown (problem_quantities.h).
  double inlier_share = std::numeric_limits<double>::quiet_NaN();
  double true_rotation_deg = std::numeric_limits<double>::quiet_NaN();
  double true_baseline = std::numeric_limits<double>::quiet_NaN();
  double true_parallax_deg = std::numeric_limits<double>::quiet_NaN();
  int instance_count = 0;  ///< How many were found, where the truth has several; one of a row that looks for one model.
  EstimationStats stats;
  bool done = false;  ///< False only for what an interrupt left out.
  int run = 0;        ///< Which of the joined runs of other seeds it is of (JoinSweep).
};

/// One method on one condition: records in the order of the dataset, only those that were done.
struct Cell {
  std::size_t condition = 0;  ///< Index into ExperimentOptions::conditions.
  std::size_t method = 0;     ///< Index into ExperimentOptions::methods.
  std::vector<ProblemRecord> records;
};

/// A problem with its fit, kept for pictures.
struct KeptFit {
  std::size_t condition = 0;
  Example example;
  Estimate estimate;
  std::size_t method = 0;
  std::string folder = {};  ///< Of its scene, whose small copies of photographs stand behind matches; empty: none.
};

/// One copy's confidences over the reverse steps of a diffusion method, for pictures.
struct ConfidenceTrace {
  std::vector<double> timesteps;               ///< From noise to data, one a step.
  std::vector<std::vector<float>> confidence;  ///< For each step N values, about -1 (not in the set) to +1 (in it).
};

/// Gives the trace of a method that has one, nothing for others. The program supplies it, so that evaluation needs to
/// know no diffusion method.
using TraceConfidence = std::function<std::optional<ConfidenceTrace>(const RobustEstimator& method,
                                                                     const Problem& problem, std::uint64_t seed)>;

struct KeptTrace {
  Example example;
  ConfidenceTrace trace;
  std::string method_label;
};

/// What a learned row's network was made by.
struct LearnedRow {
  std::size_t method = 0;
  TrainingFacts facts;
};

/// One of `count` parts of an experiment's problems, for machines that share the work (merge.h). Every part has
/// problems of every condition and method.
struct Shard {
  int index = 1;  ///< In [1, count].
  int count = 1;
  bool whole() const { return count == 1; }
  bool operator==(const Shard&) const = default;
};

/// What a run took and read, so that its numbers can be checked elsewhere.
struct RunFacts {
  double seconds = 0.0;          ///< 0: unknown.
  double peak_memory_mib = 0.0;  ///< Of the process; 0: unknown.
  /// SHA-256 of all problems' points, in their order; of several runs on other data that of their digests. Empty of
  /// shards.
  std::string data_digest;
  std::vector<std::pair<std::string, std::string>> networks;  ///< Checkpoints that rows name, with their SHA-256.
};

struct ExperimentResults {
  ExperimentOptions experiment;
  std::string dataset;  ///< The data's type.
  std::vector<LearnedRow> learned;
  std::vector<Cell> cells;  ///< Conditions outside, methods inside, in the experiment's order.
  std::vector<KeptFit> fits;
  std::string fits_label;         ///< The method of `fits` (lines, planes).
  std::vector<KeptTrace> traces;  ///< At most one.
  /// For each row with a network and condition, where the truth is known: of its probabilities, then of the matching
  /// ratio's on the same problems. DistinctCurves has what is shown.
  std::vector<ReliabilityCurve> reliability;
  bool partial = false;               ///< An interrupt stopped the run.
  Shard shard;                        ///< Which problems these are.
  std::vector<std::size_t> problems;  ///< By condition: how many there are, those of other shards included.
  RunFacts facts;
  std::vector<std::uint64_t> seeds;  ///< Of the runs that were joined, where they differ in nothing else.
  std::string git_revision;          ///< Of the program that ran.
  std::string machine;               ///< Where it ran; of joined shards all of them.

  const Cell* Find(std::size_t condition, std::size_t method) const;
};

/// What the run estimated, for estimates.h5.
EstimateFile EstimatesOf(const ExperimentResults& results);

/// Writes them into the run's folder, or removes those of an earlier run where the experiment keeps none. Throws Error.
void KeepEstimates(const ExperimentResults& results, const std::string& folder);

/// Gives the records of `results` their estimates from a file of the same run. Throws Error, starting with `name`,
/// where the two are not of the same problems.
void AddEstimates(EstimateFile file, const std::string& name, ExperimentResults* results);

/// A named number of one method, condition and scene.
struct MetricValue {
  std::string scene;
  std::string metric;
  double value = 0.0;  ///< NaN: unknown (no ground truth).
};

/// "mAA@0.5deg", "mAA@20px": a metric's name with its threshold.
std::string MetricName(const std::string& metric, const Tolerance& tolerance);

/// What is judged beside the main error.
struct MetricKinds {
  bool poses = false;      ///< Rotation and translation on their own.
  bool instances = false;  ///< Several structures at once.
  bool angles = false;     ///< The angles of these.
  bool given = false;      ///< The pose that a person is given (PoseAccuracyMetric).
  bool focals = false;     ///< Focal lengths.
};

/// The metrics of one scene's records, in the order of the files (docs/metrics.md).
std::vector<MetricValue> SceneMetrics(const std::string& scene, const std::vector<const ProblemRecord*>& records,
                                      const Tolerance& tolerance, const MetricKinds& kinds = {});

/// Stands for the scene in the metrics over all pairs.
inline constexpr const char* kAllPairs = "all_pairs";

/// What stands for the scene in the standard deviations over seeds of the metrics of `mean` or kAllPairs.
inline std::string DeviationOf(const std::string& scene) { return scene + "_seed_deviation"; }

/// Whether some record of the cells has it.
template <class Has>
bool AnyRecord(const Cell& cell, const Has& has) {
  return std::any_of(cell.records.begin(), cell.records.end(), has);
}
template <class Has>
bool AnyRecord(const ExperimentResults& results, const Has& has) {
  return std::any_of(results.cells.begin(), results.cells.end(),
                     [&](const Cell& cell) { return AnyRecord(cell, has); });
}

/// The scenes of a cell, or of a condition's cells, in the order in which they first appear.
std::vector<std::string> ScenesOf(const Cell& cell);
std::vector<std::string> ScenesOf(const ExperimentResults& results, std::size_t condition);

/// Whether rotation and translation are judged on their own: the errors are angles, and some problem knows its
/// rotation.
bool JudgesPoses(const Cell& cell, const Tolerance& tolerance);
bool JudgesPoses(const ExperimentResults& results);

/// Whether the pose that a person is given is judged (AddPoseError), in two views of known cameras or unknown focal
/// lengths: some problem's is known.
bool JudgesGivenPoses(const Cell& cell);
bool JudgesGivenPoses(const ExperimentResults& results);

/// "mAA_pose@10deg", of that pose: at the tolerance of the tables, or at 10 degrees where that is in pixels.
std::string PoseAccuracyMetric(const Tolerance& tolerance);

/// Whether several structures are judged: some problem's recall is known.
bool JudgesInstances(const Cell& cell);
bool JudgesInstances(const ExperimentResults& results);

/// Whether the angles of several structures are judged.
bool JudgesAngles(const Cell& cell);

/// The metric that intervals, differences and curves are of (AccuracyOf): "recall", or "mAA@0.5deg".
std::string AccuracyMetric(const ExperimentResults& results);
/// What axes call it.
std::string AccuracyTitle(const ExperimentResults& results);

/// The share of minimal sets that are of one true structure, by its metric's name, and of one problem.
inline constexpr const char* kSetsMetric = "one_structure_sets";
inline double SetsOf(const ProblemRecord& record) { return record.one_instance_sets; }

/// The metrics of a cell: each scene's, then `mean`, the unweighted mean over scenes (counts are summed); with several
/// scenes also those of all problems together, where large scenes weigh more: `all_pairs`. Of several runs (seeds) the
/// standard deviations of these over the runs follow (DeviationOf).
std::vector<MetricValue> CellMetrics(const Cell& cell, const Tolerance& tolerance);

/// The value of one metric in a list; NaN when it is not there.
double FindMetric(const std::vector<MetricValue>& metrics, const std::string& scene, const std::string& metric);

/// Whether the problems of one cell are among those of the other, so that their metrics may be held against each other.
bool SameProblems(const Cell& a, const Cell& b);

/// Each problem's value by scene, without those that are NaN; no scene without values. A problem that was estimated
/// with several seeds has one value, their mean.
using ValueOf = std::function<double(const ProblemRecord&)>;
SceneValues SceneValuesOf(const Cell& cell, const ValueOf& value_of);

/// Each problem's AccuracyOf by scene; empty when no problem has ground truth.
SceneValues SceneAccuracies(const Cell& cell, const Tolerance& tolerance);

/// The same of another error than the task's main one: rotation alone, say. Problems whose error is NaN are left out.
using ErrorMeasure = std::function<double(const EstimateError&)>;
SceneValues SceneAccuracies(const Cell& cell, const Tolerance& tolerance, const ErrorMeasure& error_of);

/// The accuracy of row `a` minus that of row `b`, mean over scenes, on the problems of which both know it, with its 95
/// % interval (BootstrapDifference). Nothing where a row did not run, is the same, or no truth is known.
std::optional<ConfidenceInterval> DifferenceOf(const ExperimentResults& results, std::size_t condition, std::size_t a,
                                               std::size_t b);
/// The same of another value than the accuracy.
std::optional<ConfidenceInterval> DifferenceOf(const ExperimentResults& results, std::size_t condition, std::size_t a,
                                               std::size_t b, const ValueOf& value_of);

/// The generator of the intervals.
Rng BootstrapRng(const ExperimentResults& results);

/// The row that differences are taken from: `reference`, or the first of type diffsac; -1 for none.
int ReferenceRow(const ExperimentOptions& experiment);

}  // namespace diffsac
