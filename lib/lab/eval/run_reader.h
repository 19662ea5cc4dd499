#pragma once

#include <string>

#include "lab/eval/results.h"

namespace diffsac {

/// What a run of diffsac_eval left in its folder, from config.yaml, results.json and problems.csv, with the digits of
/// that file: records and what was left out, without pictures and estimates. A problem's index is its place among all
/// that the file names of its condition. Throws Error, naming file and line, for a folder without a run, a shard's, and
/// damaged files.
ExperimentResults ReadRun(const std::string& folder);

}  // namespace diffsac
