#include "lab/eval/tables.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace diffsac {
namespace {

constexpr std::size_t kMostConditionsTogether = 3;  // In a table that shows several metrics of each.

bool HasSets(const ExperimentResults& results) {
  return IsTwoView(results.experiment.task) &&
         AnyRecord(results, [](const ProblemRecord& record) { return !std::isnan(record.all_inlier_sets); });
}

MetricTable AccuracyKind(const ExperimentResults& results, const std::string& scene, const std::string& note) {
  const std::string name = MetricName("mAA", results.experiment.tolerance());
  MetricTable kind{name + note + ", higher is better", {}, scene == "mean"};
  AddConditions(results, {"", 0, scene, name, 3, true, scene == "mean" ? &PaperValue::accuracy : nullptr}, "", &kind);
  return kind;
}

MetricTable MedianKind(const ExperimentResults& results) {
  const bool pixels = results.experiment.tolerance().pixels;
  MetricTable kind{std::string("median error in ") + (pixels ? "pixels" : "degrees") + ", lower is better", {}, true};
  AddConditions(results, {"", 0, "mean", pixels ? "median_px" : "median_deg", 3, false, &PaperValue::median_deg}, "",
                &kind);
  return kind;
}

// One table of several metrics; with many conditions, which would make it too wide, one table for each.
std::vector<MetricTable> KindsOf(const ExperimentResults& results, const std::string& heading_together,
                                 const std::string& heading_apart, const std::vector<MetricColumn>& metrics) {
  std::vector<MetricTable> kinds;
  const bool together = results.experiment.conditions.size() <= kMostConditionsTogether;
  for (const MetricColumn& metric : metrics) {
    if (!together || kinds.empty())
      kinds.push_back({together ? heading_together : heading_apart + ", " + metric.heading, {}});
    AddConditions(results, metric, together ? metric.heading : "", &kinds.back());
  }
  return kinds;
}

// Rotation or translation alone: `letter` is R or t.
std::vector<MetricTable> PoseKinds(const ExperimentResults& results, const std::string& what,
                                   const std::string& letter) {
  const Tolerance c = results.experiment.tolerance();
  const bool rotation = letter == "R";
  return KindsOf(results, what + " alone", what + " alone",
                 {{MetricName("mAA", c), 0, "mean", MetricName("mAA_" + letter, c), 3, true,
                   rotation ? &PaperValue::rotation : &PaperValue::translation},
                  {"median degrees", 0, "mean", "median_" + letter + "_deg", 3, false,
                   rotation ? &PaperValue::median_rotation_deg : &PaperValue::median_translation_deg}});
}

// Two views: the area under the recall, and how often there was no model or no pose.
std::vector<MetricTable> AreaKinds(const ExperimentResults& results, bool poses) {
  std::vector<Tolerance> thresholds = {results.experiment.tolerance()};
  if (poses) thresholds = {Tolerance(5.0), Tolerance(10.0), Tolerance(20.0)};
  std::vector<MetricColumn> metrics;
  for (const Tolerance& threshold : thresholds)
    metrics.push_back({MetricName("AUC", threshold), 0, "mean", MetricName("AUC", threshold)});
  metrics.push_back({"failures", 0, "mean", "failures", 0, false});
  const std::string of = poses ? "max(R, t)" : "errors";
  return KindsOf(results, of + ": exact AUC and failures", of, metrics);
}

// Two views: the pose that a person is given, beside the model's where both are angles and there is room.
std::vector<MetricTable> GivenPoseKinds(const ExperimentResults& results) {
  const Tolerance c = results.experiment.tolerance();
  const bool beside = !c.pixels && results.experiment.conditions.size() <= kMostConditionsTogether;
  std::vector<MetricColumn> metrics;
  if (beside) metrics.push_back({MetricName("mAA", c), 0, "mean", MetricName("mAA", c)});
  metrics.push_back({PoseAccuracyMetric(c), 0, "mean", PoseAccuracyMetric(c)});
  const std::string of = "the pose that is given (R, t with its sign)";
  return KindsOf(results, of + (beside ? " beside the model's" : ""), of, metrics);
}

MetricTable SetsKind(const ExperimentResults& results) {
  MetricTable kind{"share of all-inlier sets among the first 20 minimal sets", {}};
  AddConditions(results, {"", 0, "mean", "all_inlier_sets"}, "", &kind);
  return kind;
}

MetricTable SceneKind(const ExperimentResults& results, std::size_t condition) {
  const bool instances = JudgesInstances(results);
  const std::string name = instances ? "misclassification" : MetricName("mAA", results.experiment.tolerance());
  MetricTable kind{
      (instances ? "misclassification error in %" : name) + " by scene" + ConditionText(results.experiment, condition),
      {}};
  for (const std::string& scene : ScenesOf(results, condition))
    kind.columns.push_back({scene, condition, scene, name, instances ? 2 : 3, !instances});
  return kind;
}

}  // namespace

std::size_t MostScenes(const ExperimentResults& results) {
  std::size_t most = 0;
  for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c)
    most = std::max(most, ScenesOf(results, c).size());
  return most;
}

namespace {

// Of several structures (docs/metrics.md#several-structures): misclassification over all problems, mean with the costs
// and median, recall, what the minimal sets hold.
std::vector<MetricTable> InstanceKinds(const ExperimentResults& results) {
  // As the papers do, over all problems: AdelaideRMF's scenes are single pairs.
  const std::size_t scenes = MostScenes(results);
  const std::string all = scenes > 1 ? kAllPairs : "mean";
  std::vector<MetricTable> kinds;
  const auto add = [&](const std::string& heading, const MetricColumn& column, bool costs) {
    kinds.push_back({heading, {}, costs});
    AddConditions(results, column, "", &kinds.back());
  };
  add("misclassification error in %, mean, lower is better",
      {"", 0, all, "misclassification", 2, false, &PaperValue::misclassification}, true);
  add("misclassification error in %, median, lower is better",
      {"", 0, all, "misclassification_median", 2, false, &PaperValue::misclassification_median}, false);
  add("recall of structures" + (scenes > 1 ? ", unweighted mean over " + std::to_string(scenes) + " scenes" : "") +
          ", higher is better",
      {"", 0, "mean", "recall", 3, true, &PaperValue::recall}, false);
  if (std::any_of(results.cells.begin(), results.cells.end(), JudgesAngles)) {
    const Tolerance c = results.experiment.tolerance();
    for (const bool half : {true, false}) {
      const std::string name = MetricName("recall_AUC", half ? 0.5 * c.value : c.value);
      add(name + " of structures in %, higher is better",
          {"", 0, all, name, 2, true, half ? &PaperValue::recall_auc_half : &PaperValue::recall_auc, 100.0}, false);
    }
    const std::string within = MetricName("structures_within", c);
    add("structures within " + FixedText(c.value, 1) + "° in %, higher is better",
        {"", 0, all, within, 1, true, nullptr, 100.0}, false);
  }
  if (!AnyRecord(results, [](const ProblemRecord& record) { return !std::isnan(record.one_instance_sets); }))
    return kinds;
  add("share of the first 20 minimal sets that are of one true structure alone", {"", 0, "mean", kSetsMetric, 3},
      false);
  kinds.back().intervals = true;
  add("share of the true structures that such a set is of", {"", 0, "mean", "structures_in_sets", 3}, false);
  return kinds;
}

// What a table of means over seeds is worth: the deviation of each number over these seeds.
MetricTable DeviationKind(const ExperimentResults& results, const MetricTable& means) {
  MetricTable kind{"standard deviation over " + std::to_string(results.seeds.size()) + " seeds of " + means.heading,
                   means.columns};
  kind.heading = kind.heading.substr(0, kind.heading.find(", higher is better"));
  kind.heading = kind.heading.substr(0, kind.heading.find(", lower is better"));
  for (MetricColumn& column : kind.columns) {
    column.scene = DeviationOf(column.scene);
    column.paper = nullptr;
  }
  kind.best = false;
  return kind;
}

// Accuracy and error, or, without ground truth, inliers; of several structures what is said of those.
std::vector<MetricTable> MainKinds(const ExperimentResults& results, bool truth) {
  std::vector<MetricTable> kinds;
  if (!truth) {
    kinds.push_back({"median number of inliers (no ground truth)", {}, true});
    AddConditions(results, {"", 0, "mean", "inliers", 0}, "", &kinds.back());
    return kinds;
  }
  if (JudgesInstances(results)) {
    kinds = InstanceKinds(results);
    if (!results.seeds.empty()) kinds.push_back(DeviationKind(results, kinds.front()));
    return kinds;
  }
  const std::size_t scenes = MostScenes(results);
  kinds.push_back(AccuracyKind(
      results, "mean", scenes > 1 ? ", unweighted mean over " + std::to_string(scenes) + " scenes" : std::string()));
  if (scenes > 1) kinds.push_back(AccuracyKind(results, kAllPairs, ", mean over all pairs"));
  kinds.push_back(MedianKind(results));
  if (!results.seeds.empty()) kinds.push_back(DeviationKind(results, kinds.front()));
  return kinds;
}

}  // namespace

std::vector<Table> MakeTables(const Report& report) {
  const ExperimentResults& results = report.results;
  const ExperimentOptions& experiment = results.experiment;
  const bool truth = HasTruth(report), instances = JudgesInstances(results), poses = JudgesPoses(results) && !instances;
  std::vector<MetricTable> kinds = MainKinds(results, truth);
  const auto add = [&](const std::vector<MetricTable>& more) { kinds.insert(kinds.end(), more.begin(), more.end()); };
  if (!instances && JudgesGivenPoses(results)) add(GivenPoseKinds(results));
  if (poses) add(PoseKinds(results, "rotation", "R"));
  if (poses) add(PoseKinds(results, "translation", "t"));
  if (truth && !instances && IsTwoView(experiment.task)) add(AreaKinds(results, poses));
  if (!instances && HasSets(results)) kinds.push_back(SetsKind(results));
  for (std::size_t c = 0; truth && c < experiment.conditions.size(); ++c)
    if (ScenesOf(results, c).size() > 1) kinds.push_back(SceneKind(results, c));
  std::vector<Table> tables;
  for (const MetricTable& kind : kinds) tables.push_back(FillTable(report, kind));
  // Last, so that a terminal ends with it.
  Table models = ModelTable(results);
  if (!models.rows.empty()) tables.push_back(std::move(models));
  return tables;
}

}  // namespace diffsac
