#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/eval/estimates.h"
#include "lab/eval/experiment.h"
#include "lab/eval/metrics.h"

namespace diffsac {

/// Two views, how far an estimate is from the truth by its own covariance: the confidence, in [0, 1], of the smallest
/// region about R (t's direction) that holds the true one. A 68 % region holds the truth where it is .68 at most.
/// Covariances that say what is so give every confidence equally often.
struct PoseLevels {
  double rotation = std::numeric_limits<double>::quiet_NaN();
  double translation = std::numeric_limits<double>::quiet_NaN();  ///< NaN of cameras in one place.
};

/// One method on one problem: the estimate (whole where the experiment keeps estimates) and what the truth says of it.
/// What files have of it is listed once, in run_files.cpp and, of estimates.h5, in estimates.cpp.
struct ProblemRecord : EstimateRecord {
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
};

/// One method on one condition: records in the order of the dataset, only those that were done.
struct Cell {
  std::size_t condition = 0;  ///< Index into ExperimentOptions::conditions.
  std::size_t method = 0;     ///< Index into ExperimentOptions::methods.
  std::vector<ProblemRecord> records;
};

/// A problem whose points are kept, for pictures and labels.
struct KeptExample {
  std::size_t condition = 0;
  Example example;
  std::string folder;              ///< Of its scene, whose small copies of photographs stand behind matches.
  std::string path, name_in_file;  ///< Own points: the file, and the set in it; else empty.
  PointMatrix source;              ///< Own points: all of the set where the problem has not all of them.
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

/// Of a condition's first problem, by the first row that has one.
struct KeptTrace {
  std::size_t condition = 0, method = 0;
  std::uint64_t index = 0;  ///< The problem's.
  ConfidenceTrace trace;
};

/// Points counted in ten bins of the probability with which they are said to be inliers: how many, the sum of these
/// probabilities, and how many are true inliers.
using ReliabilityBins = std::array<std::array<double, 3>, 10>;

/// Those of the probabilities of one row, or of the matching ratio on the same problems, on one condition.
struct Reliability {
  std::string label;
  std::size_t condition = 0;
  std::map<std::string, ReliabilityBins> scenes;
};

/// What a learned row's network was made by.
struct LearnedRow {
  std::size_t method = 0;
  TrainingFacts facts;
};

/// One of `count` parts of an experiment's problems, for machines that share the work. Every part has problems of every
/// condition and method.
struct Shard {
  int index = 1;  ///< In [1, count].
  int count = 1;
  bool whole() const { return count == 1; }
};

/// What a run took and read, so that its numbers can be checked elsewhere.
struct RunFacts {
  double seconds = 0.0;
  double peak_memory_mib = 0.0;  ///< Of the process.
  std::string data_digest;       ///< SHA-256 of all problems' points, in their order; empty of shards.
  std::vector<std::pair<std::string, std::string>> networks;  ///< Checkpoints that rows name, with their SHA-256.
};

struct ExperimentResults {
  ExperimentOptions experiment;
  std::string dataset;  ///< The data's type.
  std::vector<LearnedRow> learned;
  std::vector<Cell> cells;  ///< Conditions outside, methods inside, in the experiment's order.
  std::vector<KeptExample> examples;
  std::vector<KeptTrace> traces;
  /// For each row with a network and condition, where the truth is known: of its probabilities, then of the matching
  /// ratio's on the same problems.
  std::vector<Reliability> reliability;
  bool partial = false;               ///< An interrupt stopped the run.
  Shard shard;                        ///< Which problems these are.
  std::vector<std::size_t> problems;  ///< By condition: how many there are, those of other shards included.
  RunFacts facts;
};

/// Whether some record has it.
template <class Has>
bool AnyRecord(const ExperimentResults& results, const Has& has) {
  return std::any_of(results.cells.begin(), results.cells.end(),
                     [&](const Cell& cell) { return std::any_of(cell.records.begin(), cell.records.end(), has); });
}

/// Whether several structures are judged: some problem's recall is known.
inline bool JudgesInstances(const ExperimentResults& results) {
  return AnyRecord(results, [](const ProblemRecord& record) { return !std::isnan(record.error.recall); });
}

/// "mAA@0.5deg", "mAA@20px": a metric's name with its threshold.
std::string MetricName(const std::string& metric, const Tolerance& tolerance);

}  // namespace diffsac
