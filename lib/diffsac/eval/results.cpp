#include "diffsac/eval/results.h"

#include <algorithm>
#include <cmath>

namespace diffsac {
namespace {

constexpr const char* kCounts[] = {"problems", "failures"};

bool IsCount(const std::string& metric) {
  return std::find(std::begin(kCounts), std::end(kCounts), metric) != std::end(kCounts);
}

// Scenes in the order in which they first appear.
std::vector<std::string> Scenes(const Cell& cell) {
  std::vector<std::string> scenes;
  for (const ProblemRecord& record : cell.records)
    if (std::find(scenes.begin(), scenes.end(), record.scene) == scenes.end()) scenes.push_back(record.scene);
  return scenes;
}

template <class Get>
double MedianOf(const std::vector<const ProblemRecord*>& records, const Get& get) {
  std::vector<double> values;
  for (const ProblemRecord* record : records) values.push_back(get(*record));
  return Median(std::move(values));
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

const Cell* ExperimentResults::Find(std::size_t condition, std::size_t method) const {
  for (const Cell& cell : cells)
    if (cell.condition == condition && cell.method == method) return &cell;
  return nullptr;
}

std::vector<MetricValue> SceneMetrics(const std::string& scene, const std::vector<const ProblemRecord*>& records,
                                      double threshold_deg) {
  std::vector<double> angles, offsets;
  double failures = 0;
  for (const ProblemRecord* record : records) {
    failures += record->error.failed;
    if (std::isnan(record->error.angle_deg)) continue;
    angles.push_back(record->error.angle_deg);
    offsets.push_back(record->error.offset);
  }
  const auto median = [&](auto get) { return MedianOf(records, get); };
  return {
      {scene, MetricName("mAA", threshold_deg), MeanAverageAccuracy(angles, threshold_deg)},
      {scene, MetricName("AUC", threshold_deg), AreaUnderCurve(angles, threshold_deg)},
      {scene, MetricName("acc", threshold_deg), AccuracyWithin(angles, threshold_deg)},
      {scene, "median_deg", Median(angles)},
      {scene, "median_offset", Median(offsets)},
      {scene, "problems", static_cast<double>(records.size())},
      {scene, "failures", failures},
      {scene, "inliers", median([](const ProblemRecord& r) { return r.inliers; })},
      {scene, "hypotheses", median([](const ProblemRecord& r) { return r.report.hypotheses; })},
      {scene, "unique_minimal_sets", median([](const ProblemRecord& r) { return r.report.unique_minimal_sets; })},
      {scene, "ms_features", median([](const ProblemRecord& r) { return r.report.ms_features; })},
      {scene, "ms_denoise", median([](const ProblemRecord& r) { return r.report.ms_denoise; })},
      {scene, "ms_consensus", median([](const ProblemRecord& r) { return r.report.ms_consensus; })},
      {scene, "ms_total", median([](const ProblemRecord& r) { return r.report.ms_total; })},
  };
}

std::vector<MetricValue> CellMetrics(const Cell& cell, double threshold_deg) {
  std::vector<MetricValue> all;
  if (cell.records.empty()) return all;
  for (const std::string& scene : Scenes(cell)) {
    std::vector<const ProblemRecord*> records;
    for (const ProblemRecord& record : cell.records)
      if (record.scene == scene) records.push_back(&record);
    const auto values = SceneMetrics(scene, records, threshold_deg);
    all.insert(all.end(), values.begin(), values.end());
  }
  const std::size_t kinds = SceneMetrics("", {}, threshold_deg).size();
  std::vector<MetricValue> means;
  for (std::size_t i = 0; i < kinds; ++i) means.push_back({"mean", all[i].metric, OverScenes(all, all[i].metric)});
  all.insert(all.end(), means.begin(), means.end());
  return all;
}

double FindMetric(const std::vector<MetricValue>& metrics, const std::string& scene, const std::string& metric) {
  for (const MetricValue& value : metrics)
    if (value.scene == scene && value.metric == metric) return value.value;
  return std::nan("");
}

SceneValues SceneAccuracies(const Cell& cell, double threshold_deg, std::size_t limit) {
  SceneValues values;
  const std::size_t count = limit == 0 ? cell.records.size() : std::min(limit, cell.records.size());
  for (const std::string& scene : Scenes(cell)) {
    std::vector<double> accuracies;
    for (std::size_t i = 0; i < count; ++i) {
      const ProblemRecord& record = cell.records[i];
      if (record.scene != scene || std::isnan(record.error.angle_deg)) continue;
      accuracies.push_back(AverageAccuracy(record.error.angle_deg, threshold_deg));
    }
    if (!accuracies.empty()) values.push_back(std::move(accuracies));
  }
  return values;
}

int ReferenceRow(const ExperimentOptions& experiment) {
  int found = -1;
  for (std::size_t i = experiment.methods.size(); i-- > 0;) {
    const MethodRow& row = experiment.methods[i];
    const bool is_reference = experiment.reference.empty() ? row.type == "diffsac" : row.name == experiment.reference;
    if (is_reference) found = static_cast<int>(i);
  }
  return found;
}

}  // namespace diffsac
