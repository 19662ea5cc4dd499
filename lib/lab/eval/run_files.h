#pragma once

#include <string>
#include <vector>

#include "lab/eval/results.h"

namespace diffsac {

/// The file that makes a folder a run's: it is removed before anything else is written, so that an earlier run's does
/// not pass for this one's, and written when all else is there (docs/report.md).
inline constexpr const char* kRunFile = "run.json";

/// problems.csv: a line for each problem and method (docs/metrics.md#files). Unknown values are empty; numbers have all
/// their digits.
std::string ProblemsCsv(const ExperimentResults& results);

/// What was run beside the experiment.
struct RunSetup {
  std::string checkpoint;  ///< That replaced the rows' own; empty: none.
  std::string device;
};

/// run.json: what is known of the run but not of single problems. `config`: the run's config.yaml.
std::string RunJson(const ExperimentResults& results, const RunSetup& setup, const std::string& config);

/// Of several seeds, each of which has a folder of this name in the run's.
std::string SeedsJson(const ExperimentOptions& experiment, const std::vector<int>& seeds);
std::string SeedFolder(int seed);

/// Writes problems.csv, estimates.h5 and run.json into a folder that has its config.yaml, each file whole or not at
/// all. Throws Error.
void WriteRun(const ExperimentResults& results, const RunSetup& setup, const std::string& folder);

/// Whether a folder holds what running the experiment would give: the whole results of the same measurement, newer than
/// this program and than the networks that rows name.
bool IsMade(const ExperimentOptions& experiment, const RunSetup& setup, const Shard& shard, const std::string& folder);

/// Gives a folder that IsMade the captions of the experiment, which are no measurement. Throws Error.
void UpdateCaptions(const ExperimentOptions& experiment, const std::string& folder);

/// "2/3", the second of three. Throws Error for anything else and where 1 ≤ i ≤ n does not hold.
Shard ShardFromText(const std::string& text);

}  // namespace diffsac
