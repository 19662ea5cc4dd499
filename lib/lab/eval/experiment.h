#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
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
  std::string series;                   ///< Rows of one series are joined in the pictures of budgets; empty: none.
  std::vector<std::string> conditions;  ///< Only these; all when empty.
  int max_problems = 0;  ///< Only the first so many problems (slow rows); 0: all. Shown as n in the table.
  Config config;         ///< type and the method's own options, without the keys above.
  void Bind(OptionsBinder& b);
  bool RunsOn(const std::string& condition) const;
  /// False for the reference that is told more than the points, `oracle`.
  bool Competes() const { return type != "oracle"; }
};

/// What the paper reports for one method and condition; none where it reports nothing. In YAML mAA, [mAA, median],
/// {R, t, median_R, median_t}, or those of several structures.
struct PaperValue {
  std::optional<double> accuracy, median_deg;
  /// Two views, which the paper judges by rotation and translation apart.
  std::optional<double> rotation, translation, median_rotation_deg, median_translation_deg;
  /// Several structures; the error in per cent.
  std::optional<double> misclassification, misclassification_median, recall;
  /// Its recall_AUC at half of the threshold and at the threshold, in per cent.
  std::optional<double> recall_auc_half, recall_auc;
  void Bind(OptionsBinder& b);
};
struct PaperRow {
  std::string ours;                          ///< Our row that it stands beside (PaperTable); empty: none.
  bool same_data = false;                    ///< It was measured on the same, public, problems.
  std::map<std::string, PaperValue> values;  ///< By the condition's name.
  void Bind(OptionsBinder& b);
};

/// Several budgets of one method, joined in the picture of mAA against the number of hypotheses.
struct BudgetSeries {
  std::string label;
  std::vector<std::string> methods;
};

/// A difference "a minus b" of two rows that the report shows with its interval.
struct Comparison {
  std::string a;
  std::string b;
  void Bind(OptionsBinder& binder);
};

/// What tables can be divided by, of each problem (problem_quantities.h).
enum class Quantity { kInlierShare, kPoints, kRotation, kBaseline, kParallax, kScene };
template <>
inline constexpr auto kEnumNames<Quantity> = NamesOf<Quantity>({{Quantity::kInlierShare, "inlier_share"},
                                                                {Quantity::kPoints, "points"},
                                                                {Quantity::kRotation, "true_rotation_deg"},
                                                                {Quantity::kBaseline, "true_baseline"},
                                                                {Quantity::kParallax, "true_parallax_deg"},
                                                                {Quantity::kScene, "scene"}});

/// The table's metric apart for problems of different kinds (report.h).
struct StrataOptions {
  Quantity by = Quantity::kInlierShare;
  std::vector<double> bins;       ///< Ascending edges: below the first, from one to the next, from the last on.
  std::vector<std::string> rows;  ///< Only these; all when empty.
  void Bind(OptionsBinder& b);
};

/// Where pictures find the images of scenes.
struct ImageFolder {
  std::string scenes = "*";  ///< Names of scenes; `*` stands for any text, `?` for one character.
  std::string folder;        ///< Holds the images by the names that the pairs' ids have, with any extension.
  void Bind(OptionsBinder& b);
};

struct FigureOptions {
  bool curve = true;  ///< mAA against the conditions' values.
  /// Problems a condition in the picture of fits; two views: evenly spread over the data, one picture for each method.
  /// 0: none.
  int qualitative = 1;
  std::string qualitative_method;                   ///< Whose fits; empty: the first that is not `oracle`.
  std::vector<std::string> qualitative_methods;     ///< Two views: whose matches; empty: the first three but `oracle`.
  std::vector<std::string> qualitative_conditions;  ///< Empty: up to four, evenly spread.
  std::string confidence_condition;                 ///< Where the reverse steps are shown; empty: the middle condition.
  std::vector<std::string> bars;                    ///< Rows in the picture of bars; empty: none.
  std::vector<BudgetSeries> budget;                 ///< The rows' `series`, in the order of their first rows.
  std::vector<ImageFolder> images;                  ///< Two views: `figures.images`, the first that fits a scene.
  void Bind(OptionsBinder& b);
};

/// What becomes of an experiment's data and networks that are not there: an error, or they are left out and named.
enum class Missing { kError, kLeaveOut };
template <>
inline constexpr auto kEnumNames<Missing> = NamesOf<Missing>({{Missing::kError, "error"},
                                                              {Missing::kLeaveOut, "leave_out"}});

/// Factors by name with the names of their levels.
using Factors = std::vector<std::pair<std::string, std::vector<std::string>>>;

/// One table or figure: every method on every condition. See docs/metrics.md and configs/tables/.
struct ExperimentOptions {
  std::string name = "experiment";
  std::string title;
  Task task = Task::kLine;
  std::uint64_t seed = 0;
  std::optional<std::vector<int>> seeds;  ///< A whole run with each; none: with `seed` alone.
  int problems = 2000;                    ///< For each condition; fewer when the dataset is smaller.
  int threads = 0;                        ///< 0: all cores.
  double threshold_deg = 0.5;             ///< c of mAA@c, AUC@c and acc@c (`metric.threshold_deg`).
  double threshold_px = 20.0;             ///< The same in pixels (`metric.threshold_px`).
  bool in_pixels = false;                 ///< Errors in pixels, as homographies' always are (`metric.in_pixels`).
  /// Homographies are judged by the motion that they decompose into, in degrees (`metric.pose`).
  bool pose = false;
  /// Two views: a match so near the true model counts in `inlier_share`; 0: those within the data's ε
  /// (`metric.share_within_px`).
  double share_within_px = 0.0;
  std::string condition_label = "condition";  ///< Name of the conditions' axis.
  std::string reference;                      ///< Differences "reference minus other"; empty: the first diffsac row.
  std::string notes;                          ///< A paragraph under the table.
  Missing missing = Missing::kError;
  bool estimates = true;           ///< Whether estimates.h5 is written (docs/estimates.md).
  bool report = true;              ///< Whether report.html is written (docs/report.md).
  int labels = 100;                ///< Own points: of so many inputs a file with labels is written; 0: none.
  std::string data_root = "data";  ///< Where data is that is not prepared here, as `${data_root}` in paths.
  FigureOptions figures;
  void Bind(OptionsBinder& b);
  /// The c of the task's metrics.
  Tolerance tolerance() const {
    return in_pixels || (ErrorInPixels(task) && !pose) ? Tolerance(threshold_px, true) : Tolerance(threshold_deg);
  }

  Config data;                        ///< What conditions change; of an experiment that was read it is in them.
  std::vector<Condition> conditions;  ///< One, "all", when empty.
  std::vector<EstimatorRow> methods;
  std::vector<std::pair<std::string, PaperRow>> paper;  ///< By its label.
  /// Scenes that the means over scenes count as one (KITTI's frame steps, say), by the group's name; in names of scenes
  /// `*` stands for any text, `?` for one character.
  std::vector<std::pair<std::string, std::vector<std::string>>> scene_groups;
  std::vector<Comparison> compare;
  std::vector<StrataOptions> strata;
  Factors factors;                    ///< Whose levels' combinations are rows, named by the levels with "_" between.
  std::vector<std::string> left_out;  ///< Rows, conditions and data that are not there, with what they need.
  /// The first group that holds the scene, or the scene itself.
  std::string GroupOf(const std::string& scene) const;
  /// The index of a row of this name; the number of rows when there is none.
  std::size_t RowOf(const std::string& method) const;
};

/// Reads an experiment. Throws Error (file, line, key) for unknown keys, double or missing names, references to methods
/// and conditions that don't exist.
ExperimentOptions ReadExperiment(const Config& given);

/// The whole experiment with every option of the data and the experiment filled in; reads back to the same.
std::string WriteExperiment(ExperimentOptions experiment);

/// The experiment with every key of its rows filled in (ResolvedRow), for config.yaml. Throws Error for a wrong row.
ExperimentOptions WithResolvedRows(ExperimentOptions experiment, const EstimatorContext& context);

}  // namespace diffsac
