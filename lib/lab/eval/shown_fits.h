#pragma once

#include <cstddef>
#include <vector>

#include "lab/eval/experiment.h"

namespace diffsac {

/// The row whose fits are shown: the named one, or the first that is not the oracle; -1 for none.
int FitsRow(const ExperimentOptions& experiment);

/// The rows whose fits are shown: one for lines and planes, several for two views.
std::vector<std::size_t> FitsRows(const ExperimentOptions& experiment);

/// Whether fits of a condition are shown: up to four conditions, evenly spread, or the named ones.
bool ShowsFits(const ExperimentOptions& experiment, std::size_t condition);

/// Whether the denoised confidences of a condition's first problem are shown: the middle condition or the named one.
bool ShowsTrace(const ExperimentOptions& experiment, std::size_t condition);

/// Which of a condition's problems are shown: the first ones; of two views, whose data comes scene by scene, evenly
/// spread ones. Ascending.
std::vector<std::size_t> FitPositions(const ExperimentOptions& experiment, std::size_t problems);

}  // namespace diffsac
