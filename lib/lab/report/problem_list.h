#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lab/report/report.h"

namespace diffsac {

/// A problem of one condition, which several methods were run on.
struct ListedProblem {
  std::size_t condition = 0;
  std::uint64_t index = 0;  ///< In the condition's data.
  std::string id, scene;
  int points = 0;
  double error = 0.0;  ///< Of the list's method; NaN where that did not run or no truth is known.
};

/// The problems of a run, conditions one after the other, each as its data has them.
struct ProblemList {
  std::vector<ListedProblem> problems;
  std::size_t method = 0;  ///< Whose errors rank them: the reference row, or the first that competes.
  /// The problem of a record, by its condition and index.
  std::size_t At(std::size_t condition, std::uint64_t index) const;

 private:
  friend ProblemList ListProblems(const ExperimentResults& results);
  std::vector<std::size_t> first_;  // By condition, where its problems begin.
};
ProblemList ListProblems(const ExperimentResults& results);

/// At most `most` of these errors' positions: half of them the largest, a quarter the smallest, the rest evenly spread
/// over what lies between. Unknown errors (NaN) count as smallest. Ascending; all where there are no more.
std::vector<std::size_t> LargestSmallestAndSpread(const std::vector<double>& errors, std::size_t most);

/// What of the problems goes with them into the page, by problem: its number among the pictures, or -1.
using PictureNumbers = std::vector<int>;

/// The JSON of the list (report.js reads it): a line for each problem and method, of long lists at most `most_lines`,
/// each method's largest, smallest and evenly spread errors. `left_out`: how many lines that leaves out.
std::string ProblemListJson(const ExperimentResults& results, const ProblemList& list, const PictureNumbers& pictures,
                            std::size_t most_lines, std::size_t* left_out);

}  // namespace diffsac
