#include "lab/eval/experiment.h"

#include <fnmatch.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <set>

#include "diffsac/core/status.h"
#include "lab/config/compose.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"

namespace diffsac {
namespace {

template <class Item>
std::vector<std::string> Names(const std::vector<Item>& items) {
  std::vector<std::string> names;
  for (const Item& item : items) names.push_back(item.name);
  return names;
}

template <class Item>
void CheckNames(const Config& config, const std::string& list, const std::vector<Item>& items) {
  const std::vector<std::string> names = Names(items);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string where = config.Where(list + "." + std::to_string(i));
    if (names[i].empty()) throw Error(where + ": expected a name");
    if (std::count(names.begin(), names.end(), names[i]) > 1) throw Error(where + ": '" + names[i] + "' stands twice");
  }
}

void CheckKnown(const Config& config, const std::string& key, const std::string& what,
                const std::vector<std::string>& asked, const std::vector<std::string>& known) {
  for (const std::string& name : asked) {
    if (name.empty() || std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw Error(config.Where(key) + ": no " + what + " is named '" + name + "'; did you mean '" +
                NearestWord(name, known) + "'?");
  }
}

void CheckReferences(const Config& config, const ExperimentOptions& experiment) {
  const auto methods = Names(experiment.methods), conditions = Names(experiment.conditions);
  for (std::size_t i = 0; i < experiment.methods.size(); ++i)
    CheckKnown(config, "methods." + std::to_string(i), "condition", experiment.methods[i].conditions, conditions);
  const FigureOptions& figures = experiment.figures;
  const auto check_methods = [&](const std::string& key, const std::vector<std::string>& names) {
    CheckKnown(config, key, "method", names, methods);
  };
  check_methods("reference", {experiment.reference});
  check_methods("figures.qualitative_method", {figures.qualitative_method});
  check_methods("figures.qualitative_methods", figures.qualitative_methods);
  check_methods("figures.bars", figures.bars);
  CheckKnown(config, "figures.qualitative_conditions", "condition", figures.qualitative_conditions, conditions);
  CheckKnown(config, "figures.confidence_condition", "condition", {figures.confidence_condition}, conditions);
  for (const auto& [label, row] : experiment.paper) {
    check_methods("paper." + label, {row.ours});
    for (const auto& value : row.values) CheckKnown(config, "paper." + label, "condition", {value.first}, conditions);
  }
  for (std::size_t i = 0; i < experiment.compare.size(); ++i)
    check_methods("compare." + std::to_string(i), {experiment.compare[i].a, experiment.compare[i].b});
  for (std::size_t i = 0; i < experiment.strata.size(); ++i) {
    const std::string key = "strata." + std::to_string(i);
    check_methods(key + ".rows", experiment.strata[i].rows);
    for (std::size_t k = 0; k < i; ++k)
      if (experiment.strata[k].by == experiment.strata[i].by)
        throw Error(config.Where(key) + ": '" + ToString(experiment.strata[i].by) + "' stands twice");
  }
}

std::vector<BudgetSeries> SeriesOf(const std::vector<EstimatorRow>& methods) {
  std::vector<BudgetSeries> all;
  for (const EstimatorRow& row : methods) {
    if (row.series.empty()) continue;
    auto found = std::find_if(all.begin(), all.end(), [&](const BudgetSeries& one) { return one.label == row.series; });
    if (found == all.end()) found = all.insert(all.end(), {row.series, {}});
    found->methods.push_back(row.name);
  }
  return all;
}

}  // namespace

bool EstimatorRow::RunsOn(const std::string& condition) const {
  return conditions.empty() || std::find(conditions.begin(), conditions.end(), condition) != conditions.end();
}

std::string ExperimentOptions::GroupOf(const std::string& scene) const {
  for (const auto& [group, patterns] : scene_groups)
    for (const std::string& pattern : patterns)
      if (::fnmatch(pattern.c_str(), scene.c_str(), 0) == 0) return group;
  return scene;
}

std::size_t ExperimentOptions::RowOf(const std::string& method) const {
  const auto found = std::find_if(methods.begin(), methods.end(), [&](const auto& row) { return row.name == method; });
  return static_cast<std::size_t>(found - methods.begin());
}

void Condition::Bind(OptionsBinder& b) {
  b.Field("name", name).Help("short and unique");
  b.Field("label", label).Help("heading; the name when empty");
  b.Field("value", value).Help("position on the curve's axis");
  b.Field("data", data).Help("what differs from the experiment's `data`");
  if (label.empty()) label = name;
}

void EstimatorRow::Bind(OptionsBinder& b) {
  b.Field("name", name).Help("unique; the type when empty");
  b.Field("label", label).Help("in tables and pictures; the name, with blanks for _, when empty");
  b.Field("series", series).Help("rows of one series are joined in the pictures of budgets");
  b.Field("conditions", conditions).Help("only these; all when empty");
  b.Field("max_problems", max_problems, AtLeast(0)).Help("only the first so many problems (slow rows); 0: all");
  b.Rest(config).Help("`type` and the type's own keys");
  type = config.Has("type") ? config.Text("type") : "";
  b.Require(!type.empty(), "type", "a type (ransac, diffsac, oracle, ...)");
  if (name.empty()) name = type;
  if (label.empty()) std::replace_copy(name.begin(), name.end(), std::back_inserter(label), '_', ' ');
}

void PaperValue::Bind(OptionsBinder& b) {
  b.Positional({"mAA", "median"});
  b.Field("mAA", accuracy).Help("mean average accuracy");
  b.Field("median", median_deg).Help("degrees");
  b.Field("R", rotation).Help("mAA of the rotation alone");
  b.Field("t", translation).Help("mAA of the translation alone");
  b.Field("median_R", median_rotation_deg).Help("degrees");
  b.Field("median_t", median_translation_deg).Help("degrees");
  b.Field("misclassification", misclassification).Help("several structures: mean error, per cent");
  b.Field("misclassification_median", misclassification_median).Help("the same, median");
  b.Field("recall", recall).Help("share of the structures that are found");
  b.Field("recall_auc_half", recall_auc_half).Help("their angles: recall_AUC at half of the threshold, per cent");
  b.Field("recall_auc", recall_auc).Help("the same at the threshold");
}

void PaperRow::Bind(OptionsBinder& b) {
  b.Field("ours", ours).Help("our row that it stands beside");
  b.Field("same_data", same_data).Help("it was measured on the same, public, problems");
  b.Rest(values);
}

void Comparison::Bind(OptionsBinder& binder) {
  binder.Positional({"a", "b"});
  binder.Field("a", a).Help("a row");
  binder.Field("b", b).Help("the row that is subtracted");
  binder.Require(!a.empty() && !b.empty(), "", "two methods [a, b]");
}

void StrataOptions::Bind(OptionsBinder& b) {
  b.Field("by", by).Help("what problems are divided by");
  const bool numbers = by != Quantity::kScene;
  b.Field("bins", bins).OnlyIf(numbers, "another `by` than scene").Help("ascending edges; an edge is in the bin above");
  b.Field("rows", rows).Help("only these rows; empty: all");
  const bool ascending = std::is_sorted(bins.begin(), bins.end(), std::less_equal<>());
  b.Require(!numbers || (!bins.empty() && ascending), "bins", "ascending edges, [0.1, 0.2, 0.4]");
}

void ImageFolder::Bind(OptionsBinder& b) {
  b.Field("scenes", scenes).Help("names of scenes; `*` stands for any text, `?` for one character");
  b.Field("folder", folder).Help("holds the images by the names that the pairs' ids have, with any extension");
  b.Require(!folder.empty(), "folder", "a folder of images");
}

void FigureOptions::Bind(OptionsBinder& b) {
  b.Field("curve", curve).Help("mAA against the conditions' values");
  b.Field("qualitative", qualitative, Within(0, 8)).Help("problems a condition in the pictures of fits or matches");
  b.Field("qualitative_method", qualitative_method).Help("whose fits; empty: the first that is not `oracle`");
  b.Field("qualitative_methods", qualitative_methods).Help("two views: whose matches; empty: the first three");
  b.Field("qualitative_conditions", qualitative_conditions).Help("empty: up to four, evenly spread");
  b.Field("confidence_condition", confidence_condition).Help("where reverse steps are shown; empty: the middle one");
  b.Field("bars", bars).Help("rows in the picture of bars; empty: none");
  b.Field("images", images).Help("two views: where images are, the first that fits a scene");
}

void ExperimentOptions::Bind(OptionsBinder& b) {
  b.Field("name", name).Help("of the experiment and its folder in runs/");
  b.Field("title", title).Help("of the report");
  b.Field("task", task).Help("what is estimated");
  b.Field("seed", seed).Help("of data and methods");
  b.Field("seeds", seeds, AtLeast(0)).Help("a whole run with each, whose mean the table shows; `seed` is the first");
  b.Field("problems", problems, Within(1, 1e7)).Help("for each condition; fewer when the data has fewer");
  b.Field("threads", threads, Within(0, 1024)).Help("0: all cores");
  b.GroupWith("metric", [this](OptionsBinder& metric) {
     metric.Field("threshold_deg", threshold_deg, Positive()).Help("c of mAA@c, AUC@c and acc@c");
     metric.Field("threshold_px", threshold_px, Positive()).Help("the same in pixels");
     metric.Field("in_pixels", in_pixels).Help("errors in pixels, as homographies' always are");
     metric.Field("pose", pose).Help("homographies are judged by the motion that they decompose into, in degrees");
     metric.Field("share_within_px", share_within_px, AtLeast(0.0))
         .OnlyIf(IsTwoView(task), "a task of two views")
         .Help("matches so near the true model count in `inlier_share`; 0: those within the data's threshold");
     metric.Require(!pose || task == Task::kHomography, "pose", "task homography; other tasks are judged so always");
   }).Help("c and unit of the accuracies");
  b.Field("condition_label", condition_label).Help("name of the conditions' axis");
  b.Field("reference", reference).Help("differences \"reference minus other\"; empty: the first diffsac row");
  b.Field("notes", notes).Help("a paragraph under the table");
  b.Field("missing", missing).Help("data and networks that are not there: an error, or left out and named");
  b.Field("data_root", data_root).Help("where data is that is not prepared here, `${data_root}` in paths");
  b.Field("estimates", estimates).Help("whether estimates.h5 is written (docs/estimates.md)");
  b.Field("report", report).Help("whether report.html is written (docs/report.md)");
  b.Field("labels", labels, AtLeast(0))
      .Help("data of type point_sets: of at most so many inputs a file with their points' labels is written (labels/)");
  b.Field("figures", figures).Help("what is drawn");
  b.Field("data", data).Help("docs/generators.md");
  b.Field("conditions", conditions).Help("columns of the table");
  b.Field("methods", methods).Help("rows of the table");
  b.Field("paper", paper).Help("what the paper reports, by its row and our condition");
  b.Field("scene_groups", scene_groups).Help("scenes that the means over scenes count as one");
  b.Field("compare", compare).Help("differences of two rows with their intervals");
  b.Field("strata", strata).Help("the metric by a quantity of the problems");
  b.Field("factors", factors)
      .Help("by name their levels; a row is named by one level of each, joined by \"_\" (docs/extending.md)");
  if (seeds) {
    b.Require(!seeds->empty(), "seeds", "a list of seeds");
    b.Require(std::set(seeds->begin(), seeds->end()).size() == seeds->size(), "seeds", "different seeds");
  }
  b.Require(!name.empty() && name.find('/') == std::string::npos, "name", "a name without '/'");
  b.Require(!methods.empty(), "methods", "a list of methods");
}

ExperimentOptions ReadExperiment(const Config& given) {
  const Config config = ComposeExperiment(given);
  auto experiment = ReadOptions<ExperimentOptions>(config);
  if (experiment.conditions.empty()) experiment.conditions.push_back({"all", "all", std::nullopt, Config()});
  if (!config.Has("data")) experiment.data = config.Sub("data");
  for (Condition& condition : experiment.conditions) condition.data = experiment.data.MergedWith(condition.data);
  experiment.data = Config();
  experiment.figures.budget = SeriesOf(experiment.methods);
  CheckNames(config, "conditions", experiment.conditions);
  CheckNames(config, "methods", experiment.methods);
  CheckReferences(config, experiment);
  return experiment;
}

std::string WriteExperiment(ExperimentOptions experiment) {
  for (Condition& condition : experiment.conditions)
    condition.data = ConfigFromYaml(WriteDatasetOptions(condition.data));
  return WriteYaml(std::move(experiment));
}

}  // namespace diffsac
