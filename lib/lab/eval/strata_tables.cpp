#include "lab/eval/strata_tables.h"

#include <cmath>

#include "lab/eval/effect_tables.h"
#include "lab/eval/metric_table.h"
#include "lab/eval/problem_quantities.h"

namespace diffsac {
namespace {

constexpr int kDigits = 3;

/// A table of one division and condition, without rows.
Table EmptyTable(const Report& report, const StrataReport& strata, std::size_t condition, const std::string& what,
                 const std::string& first_column) {
  Table table;
  table.heading = what + " by " + QuantityTitle(strata.options.by) + " (problems)" +
                  ConditionText(report.results.experiment, condition);
  table.columns = StrataColumns(strata, condition);
  table.columns.insert(table.columns.begin(), first_column);
  return table;
}

Table AccuracyTable(const Report& report, const StrataReport& strata, std::size_t condition) {
  const ExperimentOptions& experiment = report.results.experiment;
  Table table = EmptyTable(report, strata, condition, AccuracyMetric(report.results), "method");
  std::vector<NumberRow> numbers;
  for (const std::size_t m : StrataRows(experiment, strata.options)) {
    const Cell* cell = report.results.Find(condition, m);
    if (cell == nullptr) continue;
    NumberRow number{{}, experiment.methods[m].Competes()};
    Table::Row row{{experiment.methods[m].label}, {}, false, {""}};
    for (const StratumReport& one : strata.strata) {
      const ConfidenceInterval& accuracy = one.Of(report, *cell);
      number.values.push_back(accuracy.mean);
      row.cells.push_back(FixedText(accuracy.mean, kDigits));
      row.intervals.push_back(RangeText(accuracy, kDigits));
    }
    row.best.resize(row.cells.size());
    table.rows.push_back(std::move(row));
    numbers.push_back(std::move(number));
  }
  if (RowsShareProblems(report.results, condition))
    for (std::size_t i = 0; i < strata.strata.size(); ++i) MarkBest(numbers, i, kDigits, true, &table);
  return table;
}

Table ComparisonTable(const Report& report, const StrataReport& strata, std::size_t condition) {
  const ExperimentOptions& experiment = report.results.experiment;
  Table table = EmptyTable(report, strata, condition, "differences in " + AccuracyMetric(report.results), "A minus B");
  for (std::size_t i = 0; i < experiment.compare.size(); ++i) {
    std::vector<std::optional<ConfidenceInterval>> values;
    for (const StratumReport& one : strata.strata) values.push_back(one.differences[i][condition]);
    AddIntervalRow(ComparisonLabel(experiment, experiment.compare[i]), values, IntervalKind::kDifference, &table);
  }
  return table;
}

Table EffectsOfStrata(const Report& report, const StrataReport& strata, std::size_t condition) {
  std::vector<const FactorEffects*> effects;
  for (const StratumReport& one : strata.strata) effects.push_back(&one.effects[condition]);
  const std::string what = "effects on " + AccuracyMetric(report.results);
  return EffectTable(report.results.experiment, EmptyTable(report, strata, condition, what, "").heading,
                     StrataColumns(strata, condition), effects, &LevelEffect::accuracy);
}

std::string UnknownNote(const Report& report, const StrataReport& strata) {
  const ExperimentOptions& experiment = report.results.experiment;
  const std::string quantity = QuantityTitle(strata.options.by);
  if (!strata.known()) return "Strata by " + quantity + " are left out: it is known of no problem.";
  std::string text;
  for (std::size_t c = 0; c < experiment.conditions.size(); ++c)
    if (strata.unknown[c] > 0)
      text += (text.empty() ? "" : ", ") + experiment.conditions[c].label + " " + std::to_string(strata.unknown[c]);
  return text.empty() ? "" : "In no stratum, as their " + quantity + " is unknown: " + text + " problems.";
}

}  // namespace

std::vector<std::string> StrataColumns(const StrataReport& strata, std::size_t condition) {
  std::vector<std::string> columns;
  for (const StratumReport& one : strata.strata)
    columns.push_back(one.stratum.label + " (" + std::to_string(one.stratum.problems[condition]) + ")");
  return columns;
}

std::vector<std::size_t> StrataRows(const ExperimentOptions& experiment, const StrataOptions& options) {
  std::vector<std::size_t> rows;
  for (const std::string& name : options.rows) rows.push_back(experiment.RowOf(name));
  for (std::size_t m = 0; options.rows.empty() && m < experiment.methods.size(); ++m) rows.push_back(m);
  return rows;
}

std::vector<Table> StrataTables(const Report& report) {
  const ExperimentOptions& experiment = report.results.experiment;
  std::vector<Table> tables;
  if (!HasTruth(report)) return tables;
  for (const StrataReport& strata : report.strata)
    for (std::size_t c = 0; strata.known() && c < experiment.conditions.size(); ++c) {
      if (strata.options.by != Quantity::kScene) tables.push_back(AccuracyTable(report, strata, c));
      if (!experiment.compare.empty()) tables.push_back(ComparisonTable(report, strata, c));
      if (!experiment.factors.empty()) tables.push_back(EffectsOfStrata(report, strata, c));
    }
  return tables;
}

std::string StrataNote(const Report& report) {
  if (report.strata.empty()) return "";
  if (!HasTruth(report)) return "Strata are left out: the truth is not known.\n";
  std::string text =
      "Strata: bins of a quantity of the problems, from the lower edge on and below the upper one; in a bin every "
      "problem weighs the same, whatever its scene.";
  for (const StrataReport& strata : report.strata)
    if (const std::string note = UnknownNote(report, strata); !note.empty()) text += " " + note;
  return text + "\n";
}

}  // namespace diffsac
