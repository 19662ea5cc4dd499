#include "lab/eval/long_lines.h"

#include <algorithm>
#include <cmath>

#include "lab/eval/format.h"

namespace diffsac {
namespace {

void AddStratumRows(const StratumReport& one, LongLines* lines) {
  const ExperimentResults& results = one.stratum.results;
  for (std::size_t i = 0; i < results.cells.size(); ++i) {
    const Cell& cell = results.cells[i];
    if (cell.records.empty()) continue;
    const std::string& method = results.experiment.methods[cell.method].name;
    const auto failures = std::count_if(cell.records.begin(), cell.records.end(),
                                        [](const ProblemRecord& record) { return record.error.failed; });
    lines->Add(one.stratum.name, cell.condition, method, lines->accuracy(), one.accuracies[i]);
    lines->Add(one.stratum.name, cell.condition, method, "problems", static_cast<double>(cell.records.size()));
    lines->Add(one.stratum.name, cell.condition, method, "failures", static_cast<double>(failures));
  }
}

void AddStratumDifferences(const StratumReport& one, LongLines* lines) {
  const ExperimentOptions& experiment = one.stratum.results.experiment;
  for (std::size_t i = 0; i < experiment.compare.size(); ++i)
    for (std::size_t c = 0; c < experiment.conditions.size(); ++c)
      if (const auto& difference = one.differences[i][c])
        lines->Add(one.stratum.name, c, experiment.compare[i].a + " - " + experiment.compare[i].b, lines->accuracy(),
                   *difference);
}

}  // namespace

std::string NumberText(double value) {
  if (!std::isfinite(value)) return "";
  char text[40];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

LongLines::LongLines(const ExperimentResults& results) : results_(results), accuracy_(AccuracyMetric(results)) {}

void LongLines::Add(const std::string& scene, std::size_t condition, const std::string& method,
                    const std::string& metric, double value) {
  text_ += CsvText(results_.experiment.name) + "," + CsvText(results_.dataset) + "," + CsvText(scene) + "," +
           CsvText(results_.experiment.conditions[condition].name) + "," + CsvText(method) + "," + metric + "," +
           NumberText(value) + "\n";
}

void LongLines::Add(const std::string& scene, std::size_t condition, const std::string& method,
                    const std::string& metric, const ConfidenceInterval& interval) {
  Add(scene, condition, method, metric, interval.mean);
  if (std::isnan(interval.low)) return;
  Add(scene, condition, method, metric + "_low", interval.low);
  Add(scene, condition, method, metric + "_high", interval.high);
}

void AddEffectLines(const std::vector<FactorEffects>& effects, const std::string& scene, LongLines* lines) {
  const ExperimentOptions& experiment = lines->results().experiment;
  for (std::size_t c = 0; c < effects.size(); ++c)
    for (std::size_t f = 0; f < effects[c].size(); ++f)
      for (std::size_t l = 0; l < effects[c][f].size(); ++l) {
        const LevelEffect& effect = effects[c][f][l];
        const std::string method = experiment.factors[f].first + "=" + experiment.factors[f].second[l];
        if (effect.accuracy) lines->Add(scene, c, method, lines->accuracy(), *effect.accuracy);
        if (effect.milliseconds) lines->Add(scene, c, method, "ms", *effect.milliseconds);
        lines->Add(scene, c, method, "combinations", static_cast<double>(effect.combinations));
      }
}

void AddStrataLines(const Report& report, LongLines* lines) {
  for (const StrataReport& strata : report.strata) {
    if (!strata.known()) continue;
    for (const StratumReport& one : strata.strata) {
      AddStratumRows(one, lines);
      AddStratumDifferences(one, lines);
      AddEffectLines(one.effects, one.stratum.name, lines);
    }
  }
}

}  // namespace diffsac
