#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>

#include "core/temporary_folder.h"
#include "diffsac/core/random.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/eval/run_files.h"
#include "lab/eval/runner.h"
#include "lab/files/files.h"
#include "lab/options/config.h"

namespace diffsac::testing {

/// Fits the two points that its seed names: results depend on the problem and the seed alone.
class TwoPointEstimator : public RobustEstimator {
 public:
  explicit TwoPointEstimator(int batch = 1, std::atomic<bool>* stop = nullptr, int stop_after = 0)
      : batch_(batch), stop_(stop), stop_after_(stop_after) {}
  diffsac::Estimate DoRun(const NormalizedProblem& space, std::uint64_t seed) const override {
    const Problem& problem = space.problem();
    if (stop_ != nullptr && ++calls_ > stop_after_) *stop_ = true;
    int set[2];
    Rng(seed).Distinct(static_cast<int>(problem.points.rows()), 2, set);
    const Eigen::RowVector2d a = problem.points.row(set[0]), b = problem.points.row(set[1]);
    Eigen::Vector2d normal(a[1] - b[1], b[0] - a[0]);
    normal.normalize();
    diffsac::Estimate estimate;
    estimate.status = Status::kOk;
    estimate.model = Eigen::Vector3d(normal[0], normal[1], -normal.dot(a.transpose()));
    for (Eigen::Index i = 0; i < problem.points.rows(); ++i)
      estimate.inliers.push_back(std::abs(problem.points.row(i).dot(normal) + estimate.model[2]) <=
                                 problem.inlier_threshold);
    estimate.stats.hypotheses = 1;
    return estimate;
  }
  int PreferredBatch() const override { return batch_; }

 private:
  int batch_;
  std::atomic<bool>* stop_;
  int stop_after_;
  mutable std::atomic<int> calls_{0};
};

inline const char* kSmallExperiment = R"(
name: small
seed: 3
problems: 40
data: {type: synthetic_line, num_points: 30, split: test}
conditions:
  - {name: "0.2", value: 0.2, data: {outlier_ratio: 0.2}}
  - {name: "0.5", value: 0.5, data: {outlier_ratio: 0.5}}
methods:
  - {name: first, type: two_point, label: First}
  - {name: second, type: two_point, label: Second, max_problems: 10}
  - {name: oracle, type: oracle, label: Oracle}
)";

/// One method on one condition; null where it did not run.
inline const Cell* FindCell(const ExperimentResults& results, std::size_t condition, std::size_t method) {
  for (const Cell& cell : results.cells)
    if (cell.condition == condition && cell.method == method) return &cell;
  return nullptr;
}

inline ExperimentOptions SmallExperiment() { return ReadExperiment(ConfigFromYaml(kSmallExperiment)); }

inline RunInputs TwoPointInputs(int batch = 1) {
  const auto make = [batch](const Config& row, Task task) {
    return row.Text("type") == "oracle" ? MakeRow(row, task, {}) : std::make_unique<TwoPointEstimator>(batch);
  };
  return {make, {}, nullptr};
}

/// Two-view results with given pose errors: `first` is right on every problem of scene a (two problems) and off by
/// 5.5 degrees in rotation on those of scene b (six); `second` has 7.5 degrees of translation everywhere, and fails on
/// the last.
inline ExperimentResults MadeUpPoses() {
  ExperimentResults results;
  results.experiment = ReadExperiment(ConfigFromYaml(R"(
name: poses
task: fundamental
metric: {threshold_deg: 10}
data: {type: synthetic_two_view}
methods:
  - {name: first, type: two_point, label: First}
  - {name: second, type: two_point, label: Second}
)"));
  for (std::size_t m = 0; m < 2; ++m) {
    Cell cell{0, m, {}};
    for (int i = 0; i < 8; ++i) {
      ProblemRecord record;
      record.index = i;
      record.scene = i < 2 ? "a" : "b";
      record.status = Status::kOk;
      record.error.rotation_deg = m == 0 && i >= 2 ? 5.5 : 0.0;
      record.error.translation_deg = m == 1 ? 7.5 : 0.0;
      record.error.failed = m == 1 && i == 7;
      if (record.error.failed) record.error.rotation_deg = 180.0;
      if (record.error.failed) record.error.translation_deg = 90.0;
      record.error.angle_deg = std::max(record.error.rotation_deg, record.error.translation_deg);
      record.done = true;
      cell.records.push_back(record);
    }
    results.cells.push_back(cell);
  }
  return results;
}

/// Made-up results: two conditions, two methods and the oracle, with given errors.
inline ExperimentResults MadeUpResults() {
  ExperimentResults results;
  results.experiment = SmallExperiment();
  results.dataset = "synthetic_line";
  const double errors[3] = {0.045, 0.12, 0.01};
  for (std::size_t c = 0; c < 2; ++c) {
    for (std::size_t m = 0; m < 3; ++m) {
      Cell cell{c, m, {}};
      for (int i = 0; i < 4; ++i) {
        ProblemRecord record;
        record.index = i;
        record.id = "p" + std::to_string(i);
        record.scene = "all";
        record.status = Status::kOk;
        record.error = {errors[m] * (i + 1) * (c + 1), 0.1, false};
        record.points = 30;
        record.inliers = 20;
        record.stats.hypotheses = m == 2 ? 0 : 20;
        record.stats.ms_total = 0.5;
        record.done = true;
        cell.records.push_back(record);
      }
      results.cells.push_back(cell);
    }
  }
  return results;
}

/// The lines of problems.csv without the times, which differ from run to run.
inline std::string WithoutTimes(ExperimentResults results) {
  for (Cell& cell : results.cells)
    for (ProblemRecord& record : cell.records)
      for (double* ms :
           {&record.stats.ms_features, &record.stats.ms_network, &record.stats.ms_consensus, &record.stats.ms_total})
        *ms = 0.0;
  return ProblemsCsv(results);
}

/// Results over several structures: `first` finds all on condition 0.2 and half of them on 0.5, with sets of one
/// structure in the same shares; `second` half of that, and the misclassification error is the share that is missing.
inline ExperimentResults MadeUpInstances() {
  ExperimentResults results = MadeUpResults();
  for (Cell& cell : results.cells)
    for (ProblemRecord& record : cell.records) {
      const double share = cell.method == 2 ? 1.0 : 1.0 / static_cast<double>((1 + cell.condition) * (1 + cell.method));
      record.error.recall = share;
      record.error.misclassified = 100.0 * (1.0 - share);
      if (record.index == 0) record.error.misclassified /= 2.0;
      if (cell.method < 2) record.one_instance_sets = record.instances_in_sets = share;
      record.instance_count = 3;
      record.stats.iterations = cell.method == 0 ? 20 : 0;
    }
  return results;
}

/// Three lines of ten points each that cross, without noise, then six outliers.
inline Example LinesCross() {
  Example example;
  example.id = "lines";
  example.scene = "all";
  example.problem.inlier_threshold = 0.1;
  example.problem.points.resize(36, 2);
  example.truth.instances = {Eigen::Vector3d(0.0, 1.0, -1.0), Eigen::Vector3d(1.0, 0.0, -2.0),
                             Eigen::Vector3d(std::sqrt(0.5), -std::sqrt(0.5), 0.0)};
  for (int i = 0; i < 10; ++i) {
    const double t = 0.5 * i + 0.1;
    example.problem.points.row(i) << t, 1.0;
    example.problem.points.row(10 + i) << 2.0, t;
    example.problem.points.row(20 + i) << t, t;
  }
  for (int i = 0; i < 6; ++i) example.problem.points.row(30 + i) << 3.0 + 0.3 * i, 4.2 - 0.7 * i;
  example.truth.model = example.truth.instances[0];
  example.truth.assignment.assign(36, 0);
  for (int i = 0; i < 30; ++i) example.truth.assignment[static_cast<std::size_t>(i)] = 1 + i / 10;
  for (const std::int32_t label : example.truth.assignment) example.truth.inliers.push_back(label > 0);
  return example;
}

/// The truth as an estimate.
inline Estimate LinesFound(const Example& example) {
  Estimate estimate;
  estimate.status = Status::kOk;
  estimate.model = example.truth.model;
  estimate.instances = example.truth.instances;
  estimate.assignment = example.truth.assignment;
  estimate.inliers = example.truth.inliers;
  return estimate;
}

}  // namespace diffsac::testing
