#include "lab/eval/experiment.h"

#include <algorithm>
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
}

}  // namespace

bool EstimatorRow::RunsOn(const std::string& condition) const {
  return conditions.empty() || std::find(conditions.begin(), conditions.end(), condition) != conditions.end();
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
  b.Field("conditions", conditions).Help("only these; all when empty");
  b.Field("max_problems", max_problems, AtLeast(0)).Help("only the first so many problems (slow rows); 0: all");
  b.Rest(config).Help("`type` and the type's own keys");
  type = config.Has("type") ? config.Text("type") : "";
  b.Require(!type.empty(), "type", "a type (ransac, diffsac, oracle, ...)");
  if (name.empty()) name = type;
  if (label.empty()) std::replace_copy(name.begin(), name.end(), std::back_inserter(label), '_', ' ');
}

void ExperimentOptions::Bind(OptionsBinder& b) {
  b.Field("name", name).Help("of the experiment and its folder in runs/");
  b.Field("task", task).Help("what is estimated");
  b.Field("seed", seed).Help("of data and methods");
  b.Field("seeds", seeds, AtLeast(0)).Help("a whole run with each, whose mean the table shows; `seed` is the first");
  b.Field("problems", problems, Within(1, 1e7)).Help("for each condition; fewer when the data has fewer");
  b.Field("examples", examples, AtLeast(0)).Help("of each condition, problems whose points are kept for pictures");
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
  b.Field("missing", missing).Help("data and networks that are not there: an error, or left out and named");
  b.Field("data_root", data_root).Help("where data is that is not prepared here, `${data_root}` in paths");
  b.Field("estimates", estimates).Help("whether estimates.h5 is written (docs/estimates.md)");
  b.Field("data", data).Help("docs/generators.md");
  b.Field("conditions", conditions).Help("columns of the table");
  b.Field("methods", methods).Help("rows of the table");
  b.Field("report", report).Help("what pages show beside the numbers (docs/report.md)");
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
  if (experiment.report.Keys().empty()) experiment.report = Config();
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

std::string WriteMeasured(ExperimentOptions experiment) {
  experiment.report = Config();
  for (Condition& condition : experiment.conditions) condition.label = condition.name;
  for (EstimatorRow& row : experiment.methods) row.label = row.name;
  return WriteExperiment(std::move(experiment));
}

}  // namespace diffsac
