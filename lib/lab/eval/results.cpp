#include "lab/eval/results.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <unordered_map>

#include "lab/files/files.h"

namespace diffsac {
namespace {

constexpr const char* kCounts[] = {"problems", "failures", "may_be_chance"};

bool IsCount(const std::string& metric) {
  return std::find(std::begin(kCounts), std::end(kCounts), metric) != std::end(kCounts);
}

void AddScenes(const Cell& cell, std::vector<std::string>* scenes) {
  for (const ProblemRecord& record : cell.records)
    if (std::find(scenes->begin(), scenes->end(), record.scene) == scenes->end()) scenes->push_back(record.scene);
}

// The values that are known.
template <class Get>
std::vector<double> ValuesOf(const std::vector<const ProblemRecord*>& records, const Get& get) {
  std::vector<double> values;
  for (const ProblemRecord* record : records)
    if (const double value = get(*record); !std::isnan(value)) values.push_back(value);
  return values;
}

// What the scenes have of one metric: their sum for counts, else their mean over the scenes that know it.
double OverScenes(const std::vector<MetricValue>& scenes, const std::string& metric) {
  double sum = 0.0;
  int known = 0;
  for (const MetricValue& value : scenes) {
    if (value.metric != metric || std::isnan(value.value)) continue;
    sum += value.value;
    ++known;
  }
  return IsCount(metric) ? sum : known == 0 ? std::nan("") : sum / known;
}

}  // namespace

std::string MetricName(const std::string& metric, const Tolerance& tolerance) {
  char text[64];
  std::snprintf(text, sizeof(text), "%s@%g%s", metric.c_str(), tolerance.value, tolerance.pixels ? "px" : "deg");
  return text;
}

const Cell* ExperimentResults::Find(std::size_t condition, std::size_t method) const {
  for (const Cell& cell : cells)
    if (cell.condition == condition && cell.method == method) return &cell;
  return nullptr;
}

namespace {

/// The metrics of one scene while they are gathered.
struct SceneMetricsOf {
  const std::string& scene;
  const std::vector<const ProblemRecord*>& records;
  const Tolerance& tolerance;
  std::vector<MetricValue> metrics = {};

  void Add(const std::string& name, double value) { metrics.push_back({scene, name, value}); }
  template <class Get>
  void Median(const std::string& name, const Get& get) {
    Add(name, diffsac::Median(ValuesOf(records, get)));
  }
  template <class Get>
  void Mean(const std::string& name, const Get& get) {
    Add(name, diffsac::Mean(ValuesOf(records, get)));
  }
};

// Rotation and translation on their own, and the exact AUC at the usual thresholds, of the records with a pose error.
void AddPoseMetrics(bool focals_known, SceneMetricsOf* all) {
  const Tolerance& c = all->tolerance;
  std::vector<double> rotations, translations, worst, focals;
  std::vector<const ProblemRecord*> posed;
  for (const ProblemRecord* record : all->records) {
    if (std::isnan(record->error.rotation_deg)) continue;
    posed.push_back(record);
    rotations.push_back(record->error.rotation_deg);
    translations.push_back(record->error.translation_deg);
    worst.push_back(record->error.angle_deg);
    focals.push_back(record->error.focal);
  }
  const auto turns = ValuesOf(posed, [](const ProblemRecord&r) { return r.levels.rotation; }),
             shifts = ValuesOf(posed, [](const ProblemRecord&r) { return r.levels.translation; });
  all->Add(MetricName("mAA_R", c), MeanAverageAccuracy(rotations, c.value));
  all->Add(MetricName("mAA_t", c), MeanAverageAccuracy(translations, c.value));
  for (double degrees : {5.0, 10.0, 20.0})
    if (degrees != c.value) all->Add(MetricName("AUC", degrees), AreaUnderCurve(worst, degrees));
  all->Add("median_R_deg", Median(rotations));
  all->Add("median_t_deg", Median(translations));
  // Shares of the pairs whose covariance's region of that confidence holds the truth.
  for (const int percent : {68, 95}) {
    all->Add("held_R_" + std::to_string(percent), AccuracyWithin(turns, 0.01 * percent));
    all->Add("held_t_" + std::to_string(percent), AccuracyWithin(shifts, 0.01 * percent));
  }
  if (focals_known) all->Add("median_focal_percent", 100.0 * Median(focals));
}

Tolerance PoseTolerance(const Tolerance& tolerance) { return tolerance.pixels ? Tolerance(10.0) : tolerance; }

void AddInstanceMetrics(bool angles_known, SceneMetricsOf* all) {
  const Tolerance& c = all->tolerance;
  const auto misclassified = [](const ProblemRecord& r) { return r.error.misclassified; };
  all->Mean("misclassification", misclassified);
  all->Median("misclassification_median", misclassified);
  all->Mean("recall", [](const ProblemRecord& r) { return r.error.recall; });
  all->Mean("structures", [](const ProblemRecord& r) { return r.instance_count; });
  all->Mean(kSetsMetric, SetsOf);
  all->Mean("structures_in_sets", [](const ProblemRecord& r) { return r.instances_in_sets; });
  if (angles_known) {
    std::vector<double> angles;
    for (const ProblemRecord* record : all->records)
      angles.insert(angles.end(), record->error.instance_angles_deg.begin(), record->error.instance_angles_deg.end());
    for (const double part : {0.5 * c.value, c.value})
      all->Add(MetricName("recall_AUC", part), RecallArea(angles, part));
    all->Add(MetricName("structures_within", c), AccuracyWithin(angles, c.value));
  }
  all->Median("draws", [](const ProblemRecord& r) { return static_cast<double>(r.stats.iterations); });
}

}  // namespace

std::vector<MetricValue> SceneMetrics(const std::string& scene, const std::vector<const ProblemRecord*>& records,
                                      const Tolerance& tolerance, const MetricKinds& kinds) {
  std::vector<double> errors, accuracies, offsets;
  double failures = 0, chance = 0;
  for (const ProblemRecord* record : records) {
    failures += record->error.failed;
    chance += record->MayBeChance();
    const double error = MainError(record->error, tolerance);
    if (std::isnan(error)) continue;
    errors.push_back(error);
    accuracies.push_back(AverageAccuracyWithin(error, tolerance));
    offsets.push_back(record->error.offset);
  }
  SceneMetricsOf all{scene, records, tolerance};
  all.Add(MetricName("mAA", tolerance), Mean(accuracies));
  all.Add(MetricName("AUC", tolerance), AreaUnderCurve(errors, tolerance.value));
  all.Add(MetricName("acc", tolerance), AccuracyWithin(errors, tolerance.value));
  all.Add(tolerance.pixels ? "median_px" : "median_deg", Median(errors));
  all.Add("median_offset", Median(offsets));
  all.Add("problems", static_cast<double>(records.size()));
  all.Add("failures", failures);
  all.Add("may_be_chance", chance);
  all.Median("inliers", [](const ProblemRecord& r) { return r.inliers; });
  all.Median("hypotheses", [](const ProblemRecord& r) { return r.stats.hypotheses; });
  all.Median("unique_minimal_sets", [](const ProblemRecord& r) { return r.stats.unique_minimal_sets; });
  all.Mean("all_inlier_sets", [](const ProblemRecord& r) { return r.all_inlier_sets; });
  all.Median("ms_features", [](const ProblemRecord& r) { return r.stats.ms_features; });
  all.Median("ms_network", [](const ProblemRecord& r) { return r.stats.ms_network; });
  all.Median("ms_consensus", [](const ProblemRecord& r) { return r.stats.ms_consensus; });
  all.Median("ms_total", [](const ProblemRecord& r) { return r.stats.ms_total; });
  if (kinds.poses) AddPoseMetrics(kinds.focals, &all);
  if (kinds.given)
    all.Add(PoseAccuracyMetric(tolerance),
            MeanAverageAccuracy(ValuesOf(records, [](const ProblemRecord& r) { return r.error.pose_deg; }),
                                PoseTolerance(tolerance).value));
  if (kinds.instances) AddInstanceMetrics(kinds.angles, &all);
  return all.metrics;
}

std::vector<std::string> ScenesOf(const Cell& cell) {
  std::vector<std::string> scenes;
  AddScenes(cell, &scenes);
  return scenes;
}

std::vector<std::string> ScenesOf(const ExperimentResults& results, std::size_t condition) {
  std::vector<std::string> scenes;
  for (const Cell& cell : results.cells)
    if (cell.condition == condition) AddScenes(cell, &scenes);
  return scenes;
}

bool JudgesPoses(const Cell& cell, const Tolerance& tolerance) {
  return !tolerance.pixels &&
         AnyRecord(cell, [](const ProblemRecord& record) { return !std::isnan(record.error.rotation_deg); });
}

bool JudgesPoses(const ExperimentResults& results) {
  return std::any_of(results.cells.begin(), results.cells.end(),
                     [&](const Cell& cell) { return JudgesPoses(cell, results.experiment.tolerance()); });
}

namespace {

bool KnowsGivenPose(const ProblemRecord& record) { return !std::isnan(record.error.pose_deg); }
bool KnowsFocal(const ProblemRecord& record) { return !std::isnan(record.error.focal); }
bool KnowsRecall(const ProblemRecord& record) { return !std::isnan(record.error.recall); }

}  // namespace

bool JudgesGivenPoses(const Cell& cell) { return AnyRecord(cell, KnowsGivenPose); }
bool JudgesGivenPoses(const ExperimentResults& results) { return AnyRecord(results, KnowsGivenPose); }

std::string PoseAccuracyMetric(const Tolerance& tolerance) { return MetricName("mAA_pose", PoseTolerance(tolerance)); }

bool JudgesInstances(const Cell& cell) { return AnyRecord(cell, KnowsRecall); }
bool JudgesInstances(const ExperimentResults& results) { return AnyRecord(results, KnowsRecall); }

bool JudgesAngles(const Cell& cell) {
  return AnyRecord(cell, [](const ProblemRecord& record) { return !record.error.instance_angles_deg.empty(); });
}

std::string AccuracyMetric(const ExperimentResults& results) {
  return JudgesInstances(results) ? "recall" : MetricName("mAA", results.experiment.tolerance());
}

std::string AccuracyTitle(const ExperimentResults& results) {
  return JudgesInstances(results) ? "recall of structures" : AccuracyMetric(results);
}

namespace {

// The records of each run, seeds apart.
std::vector<Cell> RunsOf(const Cell& cell) {
  std::map<int, Cell> runs;
  for (const ProblemRecord& record : cell.records)
    runs.try_emplace(record.run, Cell{cell.condition, cell.method, {}}).first->second.records.push_back(record);
  std::vector<Cell> cells;
  for (auto& [run, one] : runs) {
    for (ProblemRecord& record : one.records) record.run = 0;
    cells.push_back(std::move(one));
  }
  return cells;
}

// The sample's standard deviation.
double Deviation(const std::vector<double>& values) {
  const double mean = Mean(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

void AddDeviations(const Cell& cell, const Tolerance& tolerance, std::vector<MetricValue>* all) {
  const std::vector<Cell> cells = RunsOf(cell);
  if (cells.size() < 2) return;
  std::vector<std::vector<MetricValue>> runs;
  for (const Cell& run : cells) runs.push_back(CellMetrics(run, tolerance));
  for (const MetricValue& value : runs.front()) {
    if (value.scene != "mean" && value.scene != kAllPairs) continue;
    std::vector<double> values;
    for (const auto& run : runs) values.push_back(FindMetric(run, value.scene, value.metric));
    all->push_back({DeviationOf(value.scene), value.metric, Deviation(values)});
  }
}

}  // namespace

std::vector<MetricValue> CellMetrics(const Cell& cell, const Tolerance& tolerance) {
  std::vector<MetricValue> all;
  if (cell.records.empty()) return all;
  const MetricKinds kinds{JudgesPoses(cell, tolerance), JudgesInstances(cell), JudgesAngles(cell),
                          JudgesGivenPoses(cell), AnyRecord(cell, KnowsFocal)};
  for (const std::string& scene : ScenesOf(cell)) {
    std::vector<const ProblemRecord*> records;
    for (const ProblemRecord& record : cell.records)
      if (record.scene == scene) records.push_back(&record);
    const auto values = SceneMetrics(scene, records, tolerance, kinds);
    all.insert(all.end(), values.begin(), values.end());
  }
  const std::size_t count = SceneMetrics("", {}, tolerance, kinds).size();
  std::vector<MetricValue> means;
  for (std::size_t i = 0; i < count; ++i) means.push_back({"mean", all[i].metric, OverScenes(all, all[i].metric)});
  const bool several = all.size() > count;
  all.insert(all.end(), means.begin(), means.end());
  if (several) {
    std::vector<const ProblemRecord*> records;
    for (const ProblemRecord& record : cell.records) records.push_back(&record);
    const auto values = SceneMetrics(kAllPairs, records, tolerance, kinds);
    all.insert(all.end(), values.begin(), values.end());
  }
  AddDeviations(cell, tolerance, &all);
  return all;
}

double FindMetric(const std::vector<MetricValue>& metrics, const std::string& scene, const std::string& metric) {
  for (const MetricValue& value : metrics)
    if (value.scene == scene && value.metric == metric) return value.value;
  return std::nan("");
}

SceneValues SceneAccuracies(const Cell& cell, const Tolerance& tolerance) {
  return SceneValuesOf(cell, [&](const ProblemRecord& record) { return AccuracyOf(record.error, tolerance); });
}

SceneValues SceneAccuracies(const Cell& cell, const Tolerance& tolerance, const ErrorMeasure& error_of) {
  return SceneValuesOf(cell, [&](const ProblemRecord& record) {
    const double error = error_of(record.error);
    return std::isnan(error) ? error : AverageAccuracyWithin(error, tolerance);
  });
}

bool SameProblems(const Cell& a, const Cell& b) {
  const auto indices = [](const Cell& cell) {
    std::vector<std::uint64_t> all;
    for (const ProblemRecord& record : cell.records) all.push_back(record.index);
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  };
  const auto of_a = indices(a), of_b = indices(b);
  return std::includes(of_a.begin(), of_a.end(), of_b.begin(), of_b.end()) ||
         std::includes(of_b.begin(), of_b.end(), of_a.begin(), of_a.end());
}

SceneValues SceneValuesOf(const Cell& cell, const ValueOf& value_of) {
  struct Sum {
    double sum = 0.0;
    int count = 0;
  };
  SceneValues values;
  for (const std::string& scene : ScenesOf(cell)) {
    std::vector<Sum> problems;
    std::unordered_map<std::uint64_t, std::size_t> places;
    for (const ProblemRecord& record : cell.records) {
      if (record.scene != scene) continue;
      const double value = value_of(record);
      if (std::isnan(value)) continue;
      const auto [place, is_new] = places.try_emplace(record.index, problems.size());
      if (is_new) problems.emplace_back();
      problems[place->second].sum += value;
      ++problems[place->second].count;
    }
    if (problems.empty()) continue;
    values.emplace_back();
    for (const Sum& problem : problems) values.back().push_back(problem.sum / problem.count);
  }
  return values;
}

Rng BootstrapRng(const ExperimentResults& results) { return Rng(results.experiment.seed).Fork("bootstrap"); }

namespace {

// Of those problems that have a value in `other` too: rows may have different numbers of problems, and a failure, say,
// has no minimal sets.
SceneValues Common(const Cell& cell, const Cell& other, const ValueOf& value_of) {
  std::set<std::uint64_t> indices;
  for (const ProblemRecord& record : other.records)
    if (!std::isnan(value_of(record))) indices.insert(record.index);
  return SceneValuesOf(cell, [&](const ProblemRecord& record) {
    return indices.contains(record.index) ? value_of(record) : std::nan("");
  });
}

}  // namespace

std::optional<ConfidenceInterval> DifferenceOf(const ExperimentResults& results, std::size_t condition, std::size_t a,
                                               std::size_t b) {
  const Tolerance c = results.experiment.tolerance();
  return DifferenceOf(results, condition, a, b,
                      [&](const ProblemRecord& record) { return AccuracyOf(record.error, c); });
}

std::optional<ConfidenceInterval> DifferenceOf(const ExperimentResults& results, std::size_t condition, std::size_t a,
                                               std::size_t b, const ValueOf& value_of) {
  const Cell *first = results.Find(condition, a), *second = results.Find(condition, b);
  if (a == b || first == nullptr || second == nullptr) return std::nullopt;
  const SceneValues of_a = Common(*first, *second, value_of);
  const SceneValues of_b = Common(*second, *first, value_of);
  if (of_a.empty() || of_b.empty()) return std::nullopt;
  return BootstrapDifference(of_a, of_b, BootstrapRng(results));
}

int ReferenceRow(const ExperimentOptions& experiment) {
  int found = -1;
  for (std::size_t i = experiment.methods.size(); i-- > 0;) {
    const EstimatorRow& row = experiment.methods[i];
    const bool is_reference = experiment.reference.empty() ? row.type == "diffsac" : row.name == experiment.reference;
    if (is_reference) found = static_cast<int>(i);
  }
  return found;
}

EstimateFile EstimatesOf(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  EstimateFile file{experiment.name, ToString(experiment.task), results.git_revision, {}};
  for (const Cell& cell : results.cells)
    file.groups.push_back({experiment.methods[cell.method].name,
                           experiment.conditions[cell.condition].name,
                           {cell.records.begin(), cell.records.end()}});
  return file;
}

void KeepEstimates(const ExperimentResults& results, const std::string& folder) {
  const std::filesystem::path path = std::filesystem::path(folder) / kEstimatesFile;
  if (results.experiment.estimates) {
    WriteEstimates(path.string(), EstimatesOf(results));
  } else {
    RemoveFile(path.string());
  }
}

void AddEstimates(EstimateFile file, const std::string& name, ExperimentResults* results) {
  const ExperimentOptions& experiment = results->experiment;
  for (Cell& cell : results->cells) {
    const std::string &method = experiment.methods[cell.method].name,
                      &condition = experiment.conditions[cell.condition].name;
    const auto group = std::find_if(file.groups.begin(), file.groups.end(), [&](const EstimateGroup& g) {
      return g.method == method && g.condition == condition;
    });
    const bool same = group != file.groups.end() &&
                      std::equal(group->records.begin(), group->records.end(), cell.records.begin(), cell.records.end(),
                                 [](const EstimateRecord& a, const ProblemRecord& b) { return a.index == b.index; });
    if (!same) throw Error(name + ": estimates and records of " + method + ", " + condition + " differ");
    for (std::size_t i = 0; i < cell.records.size(); ++i)
      static_cast<EstimateRecord&>(cell.records[i]) = std::move(group->records[i]);
  }
}

}  // namespace diffsac
