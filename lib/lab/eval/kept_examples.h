#pragma once

#include <H5Cpp.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lab/data/point_files.h"
#include "lab/eval/results.h"

namespace diffsac {

/// The group of estimates.h5 with the points of some problems, for pictures and labels (docs/estimates.md).
inline constexpr const char* kExamplesGroup = "examples";

/// Which of a condition's problems are examples (ExperimentOptions::examples): the first ones; of two views, whose data
/// comes scene by scene, evenly spread ones. Ascending.
std::vector<std::size_t> ExamplePositions(const ExperimentOptions& experiment, std::size_t problems);

/// Keeps examples while there is room for their points.
class ExampleKeeper {
 public:
  explicit ExampleKeeper(std::vector<KeptExample>* examples) : examples_(*examples) {}
  /// Of own points also what their file has beside the problem's points, which is a warning where it is gone.
  void Keep(std::size_t condition, const Example& example, const Dataset& dataset);

 private:
  void AddSource(const PointSource& source, KeptExample* kept);

  std::vector<KeptExample>& examples_;
  std::size_t bytes_ = 0;
  std::string path_;  // Of the file that was read last, and its sets.
  std::vector<PointSet> sets_;
};

/// The names of a pair's images: those that the example has, or what its id "scene/img1-img2" says; empty for another.
std::pair<std::string, std::string> ImageNames(const Example& example);

/// Writes the group; nothing without examples. Throws H5::Exception.
void PutExamples(const ExperimentResults& results, H5::H5File& file);

}  // namespace diffsac
