#include "lab/eval/tables.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lab/eval/format.h"

namespace diffsac {
namespace {

std::string General(double value) { return std::isnan(value) ? kUnknown : Format("%.3g", value); }

double MedianOverAll(const ExperimentResults& results, std::size_t method, double (*get)(const ProblemRecord&)) {
  std::vector<double> values;
  for (const Cell& cell : results.cells) {
    if (cell.method != method) continue;
    for (const ProblemRecord& record : cell.records) values.push_back(get(record));
  }
  return Median(std::move(values));
}

// "2000", or "100–2000" where conditions differ.
std::string CountText(const ExperimentResults& results, std::size_t method) {
  std::size_t low = 0, high = 0;
  for (const Cell& cell : results.cells) {
    if (cell.method != method) continue;
    low = low == 0 ? cell.records.size() : std::min(low, cell.records.size());
    high = std::max(high, cell.records.size());
  }
  return low == high ? std::to_string(high) : std::to_string(low) + kUnknown + std::to_string(high);
}

bool HasRecords(const ExperimentResults& results, std::size_t method) {
  return std::any_of(results.cells.begin(), results.cells.end(),
                     [&](const Cell& cell) { return cell.method == method; });
}

bool CountsDiffer(const ExperimentResults& results) {
  return std::any_of(results.cells.begin(), results.cells.end(),
                     [&](const Cell& cell) { return cell.records.size() != results.cells.front().records.size(); });
}

void AddCosts(const ExperimentResults& results, std::size_t method, bool with_counts, Table::Row* row) {
  const double models =
      MedianOverAll(results, method, [](const ProblemRecord& r) { return double(r.stats.hypotheses); });
  const double ms = MedianOverAll(results, method, [](const ProblemRecord& r) { return r.stats.ms_total; });
  const bool oracle = results.experiment.methods[method].type == "oracle";
  if (JudgesInstances(results)) {
    const double draws =
        MedianOverAll(results, method, [](const ProblemRecord& r) { return static_cast<double>(r.stats.iterations); });
    row->cells.push_back(oracle || draws == 0.0 ? kUnknown : FixedText(draws, 0));
  }
  row->cells.push_back(oracle ? kUnknown : FixedText(models, 0));
  row->cells.push_back(oracle ? kUnknown : General(ms));
  if (with_counts) row->cells.push_back(CountText(results, method));
}

// "[0.450, 0.570]", empty where the interval is unknown.
std::string RangeText(const ConfidenceInterval& interval, int digits) {
  if (std::isnan(interval.low)) return "";
  return "[" + FixedText(interval.low, digits) + ", " + FixedText(interval.high, digits) + "]";
}

// The 95 % interval of a cell's accuracy or of its sets, which are means over scenes.
std::string RangeOf(const Report& report, const MetricColumn& column, std::size_t method) {
  const Cell* cell = report.results.Find(column.condition, method);
  const bool of_accuracy = column.metric == AccuracyMetric(report.results);
  if (cell == nullptr || column.scene != "mean" || (!of_accuracy && column.metric != kSetsMetric)) return "";
  const ConfidenceInterval& interval = of_accuracy ? report.Of(*cell).accuracy : report.Of(*cell).sets;
  return RangeText(interval, column.digits);
}

// Marks the best value of a column, of the rows that compete; those that print the same are equally good. `numbers`: by
// row, NaN of those that do not.
void MarkBest(const std::vector<double>& numbers, std::size_t at, const MetricColumn& column, Table* table) {
  double best = std::nan("");
  for (const double value : numbers)
    if (std::isnan(best) || (column.higher_is_better ? value > best : value < best)) best = value;
  for (std::size_t r = 0; r < numbers.size(); ++r)
    table->rows[r].best[at] =
        !std::isnan(numbers[r]) && FixedText(numbers[r], column.digits) == FixedText(best, column.digits);
}

void AddEstimatorRows(const Report& report, const MetricTable& shown, bool with_counts, Table* table) {
  const ExperimentResults& results = report.results;
  std::vector<std::vector<double>> competing(shown.columns.size());
  for (std::size_t m = 0; m < results.experiment.methods.size(); ++m) {
    if (!HasRecords(results, m)) continue;
    const EstimatorRow& method = results.experiment.methods[m];
    Table::Row row{{method.label}, {}, false, {""}};
    for (std::size_t c = 0; c < shown.columns.size(); ++c) {
      const MetricColumn& column = shown.columns[c];
      const double value = column.scale * report.Metric(column.condition, m, column.scene, column.metric);
      competing[c].push_back(method.Competes() ? value : std::nan(""));
      const std::string interval = RangeOf(report, column, m);
      const bool inside = shown.intervals && !interval.empty();
      row.cells.push_back(FixedText(value, column.digits) + (inside ? " " + interval : ""));
      row.intervals.push_back(inside ? "" : interval);
    }
    if (shown.costs) AddCosts(results, m, with_counts, &row);
    row.best.resize(row.cells.size());
    row.intervals.resize(row.cells.size());
    table->rows.push_back(std::move(row));
  }
  for (std::size_t c = 0; c < shown.columns.size(); ++c)
    if (shown.best && RowsShareProblems(results, shown.columns[c].condition))
      MarkBest(competing[c], c + 1, shown.columns[c], table);
}

// With the paper's digits: two, or three where it gives three.
std::string PaperText(double value) {
  const double hundredths = 100.0 * value;
  return FixedText(value, std::abs(hundredths - std::round(hundredths)) < 1e-6 ? 2 : 3);
}

void AddPaperRows(const ExperimentResults& results, const MetricTable& shown, Table* table) {
  for (const auto& [label, paper] : results.experiment.paper) {
    Table::Row row;
    bool known = false;
    row.cells.push_back(label + (paper.same_data ? " (published)" : " (paper, other data)"));
    for (const MetricColumn& column : shown.columns) {
      const auto found = paper.values.find(results.experiment.conditions[column.condition].name);
      const bool has_value = column.paper != nullptr && found != paper.values.end();
      const auto value = has_value ? found->second.*column.paper : std::nullopt;
      known = known || value.has_value();
      row.cells.push_back(PaperText(value.value_or(std::nan(""))));
    }
    row.cells.resize(table->columns.size(), "");
    row.best.resize(row.cells.size());
    row.from_paper = true;
    if (known) table->rows.push_back(std::move(row));
  }
}

}  // namespace

std::string FixedText(double value, int digits) { return std::isnan(value) ? kUnknown : FixedNumber(value, digits); }

std::string ConditionText(const ExperimentOptions& experiment, std::size_t condition) {
  if (experiment.conditions.size() < 2) return "";
  return ", " + experiment.condition_label + " " + experiment.conditions[condition].label;
}

bool RowsShareProblems(const ExperimentResults& results, std::size_t condition) {
  const Cell* largest = nullptr;
  std::vector<const Cell*> cells;
  for (const Cell& cell : results.cells) {
    if (cell.condition != condition || !results.experiment.methods[cell.method].Competes()) continue;
    cells.push_back(&cell);
    if (largest == nullptr || cell.records.size() > largest->records.size()) largest = &cell;
  }
  return std::all_of(cells.begin(), cells.end(), [&](const Cell* cell) { return SameProblems(*cell, *largest); });
}

void AddConditions(const ExperimentResults& results, const MetricColumn& one, const std::string& unit,
                   MetricTable* table) {
  const auto& conditions = results.experiment.conditions;
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    table->columns.push_back(one);
    table->columns.back().condition = c;
    table->columns.back().heading = conditions[c].label + (unit.empty() ? "" : ": " + unit);
  }
}

Table FillTable(const Report& report, const MetricTable& shown) {
  Table table;
  table.heading = shown.heading;
  table.columns.push_back("method");
  for (const MetricColumn& column : shown.columns) table.columns.push_back(column.heading);
  const bool with_counts = shown.costs && CountsDiffer(report.results);
  if (shown.costs && JudgesInstances(report.results)) table.columns.push_back("draws");
  if (shown.costs) table.columns.insert(table.columns.end(), {"hypotheses", "ms"});
  if (with_counts) table.columns.push_back("n");
  AddEstimatorRows(report, shown, with_counts, &table);
  AddPaperRows(report.results, shown, &table);
  return table;
}

}  // namespace diffsac
