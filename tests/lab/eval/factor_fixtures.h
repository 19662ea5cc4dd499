#pragma once

#include <functional>
#include <string>

#include "lab/eval/eval_fixtures.h"

namespace diffsac::testing {

inline const char* kFactorExperiment = R"(
name: factors
task: fundamental
seed: 4
metric: {threshold_deg: 10}
data: {type: synthetic_two_view}
condition_label: matches
conditions: [{name: all}, {name: ratio}]
factors: {score: [plain, good], draws: [few, some, many]}
methods:
  plain_few: {type: two_point, label: "plain, few"}
  plain_some: {type: two_point, label: "plain, some"}
  plain_many: {type: two_point, label: "plain, many"}
  good_few: {type: two_point, label: "good, few"}
  good_some: {type: two_point, label: "good, some"}
  good_many: {type: two_point, label: "good, many"}
compare: {good_many: [plain_few]}
strata: {by: inlier_share, bins: [0.2, 0.5]}
)";

/// Results of kFactorExperiment: twelve problems in scenes a (four) and b (eight), inlier shares 0, .1, .2, ..., 1.1/12
/// a step, errors in degrees from `error`, by condition, row and problem; ten times as many milliseconds for `good`.
inline ExperimentResults MadeUpFactors(const std::function<double(std::size_t, std::size_t, int)>& error) {
  ExperimentResults results;
  results.experiment = ReadExperiment(ConfigFromYaml(kFactorExperiment, "x.yaml"));
  results.dataset = "synthetic_two_view";
  for (std::size_t c = 0; c < 2; ++c)
    for (std::size_t m = 0; m < 6; ++m) {
      Cell cell{c, m, {}};
      for (int i = 0; i < 12; ++i) {
        ProblemRecord record;
        record.index = static_cast<std::uint64_t>(i);
        record.id = "p" + std::to_string(i);
        record.scene = i < 4 ? "a" : "b";
        record.status = Status::kOk;
        record.error.angle_deg = record.error.rotation_deg = error(c, m, i);
        record.error.translation_deg = 0.0;
        record.points = 10 * i;
        record.inlier_share = i / 12.0;
        record.stats.ms_total = m < 3 ? 0.5 : 5.0;
        record.done = true;
        cell.records.push_back(record);
      }
      results.cells.push_back(std::move(cell));
    }
  return results;
}

/// With errors that differ between problems, rows and conditions without much of an order.
inline ExperimentResults MixedFactors() {
  return MadeUpFactors(
      [](std::size_t c, std::size_t m, int i) { return static_cast<double>((7 * m + 5 * i + 3 * c) % 12); });
}

}  // namespace diffsac::testing
