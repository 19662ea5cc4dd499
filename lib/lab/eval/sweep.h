#pragma once

#include <atomic>
#include <iosfwd>
#include <string>
#include <vector>

#include "diffsac/core/config.h"
#include "lab/eval/results.h"

namespace diffsac {

/// One key of an experiment's `sweep` whose values are whole runs: a path with a dot, or `seed` or `problems`. A plain
/// key is an option of the data, whose values are conditions (compose.h).
struct SweepAxis {
  std::string key;                  ///< "methods.prosac.hypotheses"
  std::string shown;                ///< As little of its end as tells it from the other axes': "hypotheses".
  std::vector<std::string> values;  ///< As YAML.
};

/// One value of each axis.
struct SweepPoint {
  std::string name;                      ///< "hypotheses=100 score=msac"; also the name of its folder.
  std::vector<std::string> parts;        ///< By axis: "hypotheses=100".
  std::vector<std::string> assignments;  ///< "methods.prosac.hypotheses=100"
};

/// The axes of an experiment's `sweep`; none for an ordinary experiment. Throws Error (file, line) for what is no list
/// of plain values, and for rows and settings that the experiment has not.
std::vector<SweepAxis> SweepAxes(const Config& experiment);

/// The experiment without its axes: what a point's assignments are put on.
Config WithoutSweepAxes(const Config& experiment);

/// All combinations, the last axis changing fastest.
std::vector<SweepPoint> SweepPoints(const std::vector<SweepAxis>& axes);

/// The results of all points as one experiment: a row for each different row of the points, named and labelled with the
/// values that make a difference to it. Points that differ in the seed alone are one row: its metrics are means over
/// the seeds, and a problem that all seeds share (one that is read, not drawn) counts once, with the mean of its
/// values; of these rows there are the factors' effects as well. Where all points differ in the seed alone the rows
/// keep names and labels, and the experiment its comparisons, the paper's rows and pictures of curves. Throws Error
/// where points have different tasks or conditions.
ExperimentResults JoinSweep(const std::vector<SweepPoint>& points, const std::vector<ExperimentResults>& results);

}  // namespace diffsac
