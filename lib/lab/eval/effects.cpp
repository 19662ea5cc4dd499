#include "lab/eval/report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace diffsac {
namespace {

/// The mean of what was added.
struct RunningMean {
  double sum = 0.0;
  int count = 0;
  void Add(double value) {
    sum += value;
    ++count;
  }
  double value() const { return sum / count; }
};

/// The row of a combination: its levels joined by "_".
std::string RowName(const std::vector<std::string>& levels) {
  std::string name;
  for (const std::string& level : levels) name += (name.empty() ? "" : "_") + level;
  return name;
}

/// Of problems, by their index.
using ProblemValues = std::map<std::uint64_t, double>;
using ProblemMeans = std::map<std::uint64_t, RunningMean>;

/// A row of one level and, but for the first level, the row that differs in that level alone.
struct RowPair {
  const Cell* of_level = nullptr;
  const Cell* of_first = nullptr;
};

ProblemValues ValuesOf(const Cell& cell, const ValueOf& value_of) {
  ProblemMeans means;  // Several seeds of a problem are one value.
  for (const ProblemRecord& record : cell.records)
    if (const double value = value_of(record); !std::isnan(value)) means[record.index].Add(value);
  ProblemValues values;
  for (const auto& [index, mean] : means) values.emplace(index, mean.value());
  return values;
}

std::map<std::uint64_t, std::string> ScenesOf(const std::vector<RowPair>& rows) {
  std::map<std::uint64_t, std::string> scenes;
  for (const RowPair& row : rows)
    for (const ProblemRecord& record : row.of_level->records) scenes.emplace(record.index, record.scene);
  return scenes;
}

/// Each problem's mean over the rows, of the value or of its difference, by scene.
SceneValues MeansOver(const std::vector<RowPair>& rows, const ValueOf& value_of) {
  ProblemMeans means;
  for (const RowPair& row : rows) {
    const ProblemValues first = row.of_first == nullptr ? ProblemValues() : ValuesOf(*row.of_first, value_of);
    for (const auto& [index, value] : ValuesOf(*row.of_level, value_of)) {
      const auto other = first.find(index);
      if (row.of_first == nullptr)
        means[index].Add(value);
      else if (other != first.end())
        means[index].Add(value - other->second);
    }
  }
  const std::map<std::uint64_t, std::string> scenes = ScenesOf(rows);
  std::map<std::string, std::size_t> places;
  SceneValues values;
  for (const auto& [index, mean] : means) {
    const auto [place, is_new] = places.try_emplace(scenes.at(index), values.size());
    if (is_new) values.emplace_back();
    values[place->second].push_back(mean.value());
  }
  return values;
}

std::optional<ConfidenceInterval> IntervalOf(const ExperimentResults& results, const std::vector<RowPair>& rows,
                                             const ValueOf& value_of) {
  const SceneValues values = MeansOver(rows, value_of);
  if (values.empty()) return std::nullopt;
  return BootstrapMean(values, BootstrapRng(results));
}

/// The rows of one level, where the first level has the same.
std::vector<RowPair> RowsOf(const ExperimentResults& results, std::size_t condition, std::size_t factor,
                            const std::string& level) {
  const ExperimentOptions& experiment = results.experiment;
  const auto cell_of = [&](const std::vector<std::string>& levels) {
    const Cell* cell = results.Find(condition, experiment.RowOf(RowName(levels)));
    return cell == nullptr || cell->records.empty() ? nullptr : cell;
  };
  const std::string& first = experiment.factors[factor].second.front();
  std::vector<RowPair> rows;
  for (std::vector<std::string> levels : CombinationsOf(experiment.factors)) {
    if (levels[factor] != level) continue;
    RowPair row{cell_of(levels), nullptr};
    levels[factor] = first;
    if (level != first) row.of_first = cell_of(levels);
    if (row.of_level != nullptr && (level == first || row.of_first != nullptr)) rows.push_back(row);
  }
  return rows;
}

double LogMilliseconds(const ProblemRecord& record) {
  return record.stats.ms_total > 0.0 ? std::log(record.stats.ms_total) : std::nan("");
}

}  // namespace

std::vector<std::vector<std::string>> CombinationsOf(const Factors& factors) {
  std::vector<std::vector<std::string>> all(1);
  for (const auto& [name, levels] : factors) {
    std::vector<std::vector<std::string>> longer;
    for (const std::vector<std::string>& combination : all)
      for (const std::string& level : levels) {
        longer.push_back(combination);
        longer.back().push_back(level);
      }
    all = std::move(longer);
  }
  return all;
}

FactorEffects EffectsOf(const ExperimentResults& results, std::size_t condition) {
  const ExperimentOptions& experiment = results.experiment;
  const Tolerance tolerance = experiment.tolerance();
  FactorEffects effects;
  for (std::size_t f = 0; f < experiment.factors.size(); ++f) {
    effects.emplace_back();
    for (const std::string& level : experiment.factors[f].second) {
      const std::vector<RowPair> rows = RowsOf(results, condition, f, level);
      LevelEffect effect{rows.size(), {}, {}};
      effect.accuracy =
          IntervalOf(results, rows, [&](const ProblemRecord& record) { return AccuracyOf(record.error, tolerance); });
      effect.milliseconds = IntervalOf(results, rows, LogMilliseconds);
      if (effect.milliseconds)
        for (double* end : {&effect.milliseconds->mean, &effect.milliseconds->low, &effect.milliseconds->high})
          *end = std::exp(*end);
      effects.back().push_back(effect);
    }
  }
  return effects;
}

}  // namespace diffsac
