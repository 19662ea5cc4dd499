#include "lab/report/compare_runs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "diffsac/core/status.h"
#include "lab/config/changed_keys.h"

namespace diffsac {
namespace {

/// Scene, id, and which of the estimates of this problem: joined grids have several, of as many seeds.
using ProblemKey = std::tuple<std::string, std::string, int>;

/// The keys of a cell's records, in their order.
std::vector<ProblemKey> KeysOf(const Cell& cell) {
  std::map<std::pair<std::string, std::string>, int> seen;
  std::vector<ProblemKey> keys;
  for (const ProblemRecord& record : cell.records)
    keys.emplace_back(record.scene, record.id, seen[{record.scene, record.id}]++);
  return keys;
}

/// The records of two cells, problem by problem: the same problems in the same order, numbered from 0.
struct PairedCells {
  Cell a, b;
  std::size_t only_a = 0, only_b = 0;
};

PairedCells Paired(const Cell& a, const Cell& b) {
  const std::vector<ProblemKey> keys_a = KeysOf(a), keys_b = KeysOf(b);
  std::map<ProblemKey, const ProblemRecord*> of_b;
  for (std::size_t i = 0; i < keys_b.size(); ++i) of_b.emplace(keys_b[i], &b.records[i]);
  PairedCells paired{{0, 0, {}, {}}, {0, 1, {}, {}}};
  for (std::size_t i = 0; i < keys_a.size(); ++i) {
    const auto found = of_b.find(keys_a[i]);
    if (found == of_b.end()) continue;
    paired.a.records.push_back(a.records[i]);
    paired.b.records.push_back(*found->second);
    paired.a.records.back().index = paired.b.records.back().index = paired.a.records.size() - 1;
  }
  paired.only_a = a.records.size() - paired.a.records.size();
  paired.only_b = b.records.size() - paired.b.records.size();
  return paired;
}

double MedianOf(const Cell& cell, double (*get)(const ProblemRecord&)) {
  std::vector<double> values;
  for (const ProblemRecord& record : cell.records) values.push_back(get(record));
  return Median(values);
}

double Milliseconds(const ProblemRecord& record) { return record.report.ms_total; }
double Inliers(const ProblemRecord& record) { return record.inliers; }

RowComparison ComparedRow(const ExperimentResults& a, PairedCells paired) {
  ExperimentResults both;
  both.experiment.task = a.experiment.task;
  both.experiment.seed = a.experiment.seed;
  both.experiment.threshold_deg = a.experiment.threshold_deg;
  both.experiment.threshold_px = a.experiment.threshold_px;
  both.experiment.in_pixels = a.experiment.in_pixels;
  both.experiment.pose = a.experiment.pose;
  both.experiment.conditions.resize(1);
  both.experiment.methods.resize(2);
  RowComparison row;
  row.problems = paired.a.records.size();
  row.only_a = paired.only_a;
  row.only_b = paired.only_b;
  row.ms_a = MedianOf(paired.a, &Milliseconds);
  row.ms_b = MedianOf(paired.b, &Milliseconds);
  row.a = MedianOf(paired.a, &Inliers);
  row.b = MedianOf(paired.b, &Inliers);
  both.cells = {std::move(paired.a), std::move(paired.b)};
  row.difference = DifferenceOf(both, 0, 1, 0);
  if (!row.difference) return row;
  const Tolerance tolerance = both.experiment.tolerance();
  const std::string metric = AccuracyMetric(both);
  row.a = FindMetric(CellMetrics(both.cells[0], tolerance), "mean", metric);
  row.b = FindMetric(CellMetrics(both.cells[1], tolerance), "mean", metric);
  return row;
}

/// How much two records differ, most important first.
std::tuple<double, double, int> ChangeOf(const ChangedProblem& problem, const Tolerance& tolerance) {
  const double accuracy = std::isnan(problem.accuracy_change) ? 0.0 : std::abs(problem.accuracy_change);
  double error = std::abs(ShownError(problem.b.error, tolerance) - ShownError(problem.a.error, tolerance));
  if (std::isnan(error)) error = 0.0;
  return {accuracy, error, std::abs(problem.a.inliers - problem.b.inliers)};
}

bool Differs(const ChangedProblem& problem, const Tolerance& tolerance) {
  return problem.a.status != problem.b.status || ChangeOf(problem, tolerance) != std::tuple{0.0, 0.0, 0};
}

void AddChanged(const PairedCells& paired, const std::string& condition, const std::string& row,
                RunComparison* comparison) {
  const Tolerance& tolerance = comparison->tolerance;
  for (std::size_t i = 0; i < paired.a.records.size(); ++i) {
    const ProblemRecord &a = paired.a.records[i], &b = paired.b.records[i];
    const auto accuracy = [&](const ProblemRecord& record) { return AccuracyOf(record.error, tolerance); };
    ChangedProblem problem{condition, row, a.scene, a.id, a, b, accuracy(b) - accuracy(a)};
    if (Differs(problem, tolerance)) comparison->changed.push_back(std::move(problem));
  }
}

void KeepMostChanged(RunComparison* comparison) {
  auto& changed = comparison->changed;
  std::stable_sort(changed.begin(), changed.end(), [&](const ChangedProblem& a, const ChangedProblem& b) {
    return ChangeOf(a, comparison->tolerance) > ChangeOf(b, comparison->tolerance);
  });
  if (changed.size() > kMostChanged) changed.resize(kMostChanged);
}

/// The row of B that stands for a row of A; the number of B's rows where there is none.
std::size_t Counterpart(const ExperimentOptions& a, std::size_t row, const ExperimentOptions& b) {
  if (a.methods.size() == 1 && b.methods.size() == 1) return 0;
  return b.RowOf(a.methods[row].name);
}

std::string RowName(const ExperimentOptions& a, std::size_t row, const ExperimentOptions& b, std::size_t other) {
  const std::string &first = a.methods[row].label, &second = b.methods[other].label;
  return a.methods[row].name == b.methods[other].name ? first : first + " → " + second;
}

template <class Named>
void AddOnlyOne(const std::vector<Named>& a, const std::vector<Named>& b, const std::string& what,
                const std::string& run, std::vector<std::string>* lines) {
  for (const Named& one : a)
    if (std::none_of(b.begin(), b.end(), [&](const Named& other) { return other.name == one.name; }))
      lines->push_back(what + " '" + one.name + "' is in " + run + " alone");
}

std::vector<std::string> DifferentKeys(const ExperimentOptions& a, const ExperimentOptions& b) {
  std::vector<std::string> lines;
  for (const ChangedKey& key : ChangedKeys(WriteExperiment(a), WriteExperiment(b)))
    lines.push_back(key.key + ": " + key.before.value_or(kUnknown) + " → " + key.now.value_or(kUnknown));
  return lines;
}

std::vector<std::string> KeptKeys(std::vector<std::string> lines) {
  if (lines.size() <= kMostKeys) return lines;
  const std::size_t more = lines.size() - kMostKeys;
  lines.resize(kMostKeys);
  lines.push_back("and " + std::to_string(more) + " more");
  return lines;
}

/// Why runs that have rows and conditions in common share no problem: generated data of another seed or other options
/// has other problems, which their ids say.
std::string Drawn(const ExperimentResults& a, const ExperimentResults& b) {
  const auto first_id = [](const ExperimentResults& results) {
    return results.cells.empty() || results.cells.front().records.empty() ? ""
                                                                          : results.cells.front().records.front().id;
  };
  const std::string of_a = first_id(a), of_b = first_id(b);
  if (of_a.find('@') == std::string::npos && of_b.find('@') == std::string::npos) return "";
  return ": their data was drawn with another seed or other options (" + of_a + ", " + of_b + ")";
}

void CheckComparable(const ExperimentResults& a, const ExperimentResults& b, const std::string& both) {
  if (a.experiment.task != b.experiment.task)
    throw Error("--compare: " + both + " are of different tasks: " + ToString(a.experiment.task) + " and " +
                ToString(b.experiment.task));
  const std::string in_a = AccuracyMetric(a), in_b = AccuracyMetric(b);
  if (in_a != in_b) throw Error("--compare: " + both + " are judged by different metrics: " + in_a + " and " + in_b);
}

}  // namespace

RunComparison CompareRuns(const ExperimentResults& a, const ExperimentResults& b, const std::string& name_a,
                          const std::string& name_b) {
  const std::string both = "'" + name_a + "' and '" + name_b + "'";
  CheckComparable(a, b, both);
  RunComparison comparison{name_a, name_b, AccuracyMetric(a), a.experiment.tolerance(), {}, {}, {}, {}};
  const ExperimentOptions &of_a = a.experiment, &of_b = b.experiment;
  bool truth = false;
  for (std::size_t c = 0; c < of_a.conditions.size(); ++c)
    for (std::size_t m = 0; m < of_a.methods.size(); ++m) {
      const std::string& condition = of_a.conditions[c].name;
      const auto at = std::find_if(of_b.conditions.begin(), of_b.conditions.end(),
                                   [&](const Condition& other) { return other.name == condition; });
      const std::size_t other = Counterpart(of_a, m, of_b);
      if (at == of_b.conditions.end() || other >= of_b.methods.size()) continue;
      const Cell* first = a.Find(c, m);
      const Cell* second = b.Find(static_cast<std::size_t>(at - of_b.conditions.begin()), other);
      if (first == nullptr || second == nullptr) continue;
      const PairedCells paired = Paired(*first, *second);
      const std::string row = RowName(of_a, m, of_b, other);
      if (paired.a.records.empty()) {
        comparison.only_one.push_back(row + ", " + of_a.conditions[c].label + ": no problem is in both runs");
        continue;
      }
      AddChanged(paired, of_a.conditions[c].label, row, &comparison);
      comparison.rows.push_back(ComparedRow(a, paired));
      comparison.rows.back().condition = of_a.conditions[c].label;
      comparison.rows.back().row = row;
      truth = truth || comparison.rows.back().difference;
    }
  if (comparison.rows.empty()) throw Error("--compare: " + both + " share no row on the same problems" + Drawn(a, b));
  if (!truth) comparison.metric = "inliers";
  KeepMostChanged(&comparison);
  const bool one_each = of_a.methods.size() == 1 && of_b.methods.size() == 1;
  if (!one_each) {
    AddOnlyOne(of_a.methods, of_b.methods, "row", name_a, &comparison.only_one);
    AddOnlyOne(of_b.methods, of_a.methods, "row", name_b, &comparison.only_one);
  }
  AddOnlyOne(of_a.conditions, of_b.conditions, "condition", name_a, &comparison.only_one);
  AddOnlyOne(of_b.conditions, of_a.conditions, "condition", name_b, &comparison.only_one);
  comparison.configuration = KeptKeys(DifferentKeys(of_a, of_b));
  return comparison;
}

}  // namespace diffsac
