#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "lab/report/report.h"

namespace diffsac {

/// A problem that two runs answer differently.
struct ChangedProblem {
  std::string condition, row, scene, id;
  ProblemRecord a, b;
  double accuracy_change = 0.0;  ///< AverageAccuracy of B minus that of A; NaN without truth.
};

/// One row of two runs on one condition, on the problems that both have.
struct RowComparison {
  std::string condition, row;
  std::size_t problems = 0, only_a = 0, only_b = 0;
  double a = 0.0, b = 0.0;                       ///< mAA, mean over scenes; without truth the median number of inliers.
  std::optional<ConfidenceInterval> difference;  ///< B − A (BootstrapDifference); without truth nothing.
  double ms_a = 0.0, ms_b = 0.0;                 ///< Medians.
};

/// What two runs differ in.
struct RunComparison {
  std::string name_a, name_b;
  std::string metric;  ///< Of `a` and `b`.
  Tolerance tolerance = 1.0;
  std::vector<RowComparison> rows;         ///< Conditions outside, rows inside, in the order of A.
  std::vector<ChangedProblem> changed;     ///< The largest changes first, kMostChanged at most.
  std::vector<std::string> only_one;       ///< Rows and conditions of one run alone, a line each.
  std::vector<std::string> configuration;  ///< "key: value of A → value of B", kMostKeys at most.
};

inline constexpr std::size_t kMostChanged = 30;
inline constexpr std::size_t kMostKeys = 40;

/// Rows of the same name on conditions of the same name are compared, problem by problem (scene and id); runs of one
/// row each whatever the rows are called. Throws Error where the runs are of different tasks or metrics, or share no
/// row, condition or problem.
RunComparison CompareRuns(const ExperimentResults& a, const ExperimentResults& b, const std::string& name_a,
                          const std::string& name_b);

/// The rows' differences, then the problems that changed most.
std::vector<Table> ComparisonTables(const RunComparison& comparison);

/// `diffsac_eval --compare A B`: reads both folders, prints the comparison and writes it to a folder (empty:
/// runs/compare-A-B) as compare.md, compare.csv and report.html. Throws Error.
void CompareFolders(const std::vector<std::string>& folders, const std::string& output, std::ostream& out);

}  // namespace diffsac
