#include "lab/eval/effect_tables.h"

#include <algorithm>

namespace diffsac {
namespace {

IntervalKind KindOfEffect(EffectPart part, const FactorLevel& at) {
  if (part == &LevelEffect::accuracy) return at.level == 0 ? IntervalKind::kValue : IntervalKind::kDifference;
  return at.level == 0 ? IntervalKind::kMilliseconds : IntervalKind::kRatio;
}

}  // namespace

std::vector<FactorLevel> LevelsOf(const ExperimentOptions& experiment) {
  std::vector<FactorLevel> levels;
  for (std::size_t f = 0; f < experiment.factors.size(); ++f)
    for (std::size_t l = 0; l < experiment.factors[f].second.size(); ++l) levels.push_back({f, l});
  return levels;
}

std::string LevelName(const ExperimentOptions& experiment, const FactorLevel& at) {
  const auto& [factor, levels] = experiment.factors[at.factor];
  return factor + ": " + levels[at.level];
}

Table EffectTable(const ExperimentOptions& experiment, const std::string& heading,
                  const std::vector<std::string>& columns, const std::vector<const FactorEffects*>& effects,
                  EffectPart part) {
  Table table;
  table.heading = heading;
  table.columns.push_back("factor: level");
  table.columns.insert(table.columns.end(), columns.begin(), columns.end());
  for (const FactorLevel& at : LevelsOf(experiment)) {
    std::vector<std::optional<ConfidenceInterval>> values;
    for (const FactorEffects* one : effects) values.push_back((*one)[at.factor][at.level].*part);
    AddIntervalRow(LevelName(experiment, at), values, KindOfEffect(part, at), &table);
  }
  return table;
}

std::vector<Table> EffectTables(const Report& report) {
  const ExperimentOptions& experiment = report.results.experiment;
  if (experiment.factors.empty()) return {};
  std::vector<std::string> columns;
  std::vector<const FactorEffects*> effects;
  for (std::size_t c = 0; c < experiment.conditions.size(); ++c) {
    columns.push_back(experiment.conditions[c].label);
    effects.push_back(&report.effects[c]);
  }
  std::vector<Table> tables;
  const std::string of = ", mean over the other factors' levels, with 95 % bootstrap intervals";
  if (HasTruth(report))
    tables.push_back(EffectTable(experiment, "effects on " + AccuracyMetric(report.results) + of, columns, effects,
                                 &LevelEffect::accuracy));
  tables.push_back(
      EffectTable(experiment, "effects on milliseconds, as ratios" + of, columns, effects, &LevelEffect::milliseconds));
  return tables;
}

std::string MissingCombinations(const Report& report) {
  const ExperimentOptions& experiment = report.results.experiment;
  const std::size_t rows = CombinationsOf(experiment.factors).size();
  std::string text;
  for (const FactorLevel& at : LevelsOf(experiment)) {
    const std::size_t all = rows / experiment.factors[at.factor].second.size();
    std::size_t least = all;
    for (const FactorEffects& effects : report.effects)
      least = std::min(least, effects[at.factor][at.level].combinations);
    if (least < all)
      text += (text.empty() ? "Of fewer combinations: " : ", ") + LevelName(experiment, at) + " " +
              std::to_string(least) + " of " + std::to_string(all);
  }
  return text.empty() ? "" : text + ".\n";
}

}  // namespace diffsac
