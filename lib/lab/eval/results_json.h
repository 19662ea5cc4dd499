#pragma once

#include <string>

#include "lab/eval/report.h"

namespace diffsac {

/// results.json: what was run, for each method and condition the metrics of every scene, the bootstrap interval of mAA
/// and that of the reference method's mAA minus its own, the experiment's comparisons, and whatever else scripts/report
/// tells: the tables as they are printed, effects and strata as numbers, what pictures are asked for. Unknown values
/// are null. `config`: the run's config.yaml, whose first lines say by what, where and when it was run.
std::string ResultsJson(const Report& report, const std::string& config = "");

}  // namespace diffsac
