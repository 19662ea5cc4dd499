#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/problem/tasks.h"
#include "lab/config/make_estimator.h"
#include "lab/eval/metrics.h"
#include "lab/ground_truth/task_truth.h"
#include "lab/options/options.h"

namespace diffsac {

/// A column of the table: the base data with some options changed.
struct Condition {
  std::string name;             ///< Short and unique: "0.5".
  std::string label;            ///< Heading; the name when empty.
  std::optional<double> value;  ///< Position on the curve's axis; none: not on it.
  Config data;                  ///< The base data merged with this condition's overrides.
  void Bind(OptionsBinder& b);
};

/// A row of the table.
struct EstimatorRow {
  std::string name;                     ///< Unique; `--methods` and the output files use it.
  std::string type;                     ///< For the registry; `oracle` is computed by the runner.
  std::string label;                    ///< In tables and pictures; the name when empty.
  std::vector<std::string> conditions;  ///< Only these; all when empty.
  int max_problems = 0;  ///< Only the first so many problems (slow rows); 0: all. Shown as n in the table.
  Config config;         ///< type and the method's own options, without the keys above.
  void Bind(OptionsBinder& b);
  bool RunsOn(const std::string& condition) const;
  /// False for the reference that is told more than the points, `oracle`.
  bool Competes() const { return type != "oracle"; }
};

/// What becomes of an experiment's data and networks that are not there: an error, or they are left out and named.
enum class Missing { kError, kLeaveOut };
template <>
inline constexpr auto kEnumNames<Missing> = NamesOf<Missing>({{Missing::kError, "error"},
                                                              {Missing::kLeaveOut, "leave_out"}});

/// One table or figure: every method on every condition. See docs/metrics.md and configs/tables/.
struct ExperimentOptions {
  std::string name = "experiment";
  Task task = Task::kLine;
  std::uint64_t seed = 0;
  std::optional<std::vector<int>> seeds;  ///< A whole run with each; none: with `seed` alone.
  int problems = 2000;                    ///< For each condition; fewer when the dataset is smaller.
  int examples = 50;                      ///< Of each condition, problems whose points are kept for pictures; 0: none.
  int threads = 0;                        ///< 0: all cores.
  double threshold_deg = 0.5;             ///< c of mAA@c, AUC@c and acc@c (`metric.threshold_deg`).
  double threshold_px = 20.0;             ///< The same in pixels (`metric.threshold_px`).
  bool in_pixels = false;                 ///< Errors in pixels, as homographies' always are (`metric.in_pixels`).
  /// Homographies are judged by the motion that they decompose into, in degrees (`metric.pose`).
  bool pose = false;
  /// Two views: a match so near the true model counts in `inlier_share`; 0: those within the data's ε
  /// (`metric.share_within_px`).
  double share_within_px = 0.0;
  Missing missing = Missing::kError;
  bool estimates = true;           ///< Whether estimates.h5 is written (docs/estimates.md).
  std::string data_root = "data";  ///< Where data is that is not prepared here, as `${data_root}` in paths.
  void Bind(OptionsBinder& b);
  /// The c of the task's metrics.
  Tolerance tolerance() const {
    return in_pixels || (ErrorInPixels(task) && !pose) ? Tolerance(threshold_px, true) : Tolerance(threshold_deg);
  }

  Config data;                        ///< What conditions change; of an experiment that was read it is in them.
  std::vector<Condition> conditions;  ///< One, "all", when empty.
  std::vector<EstimatorRow> methods;
  /// What pages show beside the numbers, for scripts/report alone (docs/report.md): kept as it stands.
  Config report;
  std::vector<std::string> left_out;  ///< Rows, conditions and data that are not there, with what they need.
  /// The index of a row of this name; the number of rows when there is none.
  std::size_t RowOf(const std::string& method) const;
};

/// Reads an experiment. Throws Error (file, line, key) for unknown keys, double or missing names, references to methods
/// and conditions that don't exist.
ExperimentOptions ReadExperiment(const Config& given);

/// The whole experiment with every option of the data and the experiment filled in; reads back to the same.
std::string WriteExperiment(ExperimentOptions experiment);

/// The same without captions, which are labels and the block `report`: two experiments that agree here measure the
/// same.
std::string WriteMeasured(ExperimentOptions experiment);

/// The experiment with every key of its rows filled in (ResolvedRow), for config.yaml. Throws Error for a wrong row.
ExperimentOptions WithResolvedRows(ExperimentOptions experiment, const EstimatorContext& context);

}  // namespace diffsac
