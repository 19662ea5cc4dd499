#include "lab/eval/shown_fits.h"

#include <algorithm>

namespace diffsac {

int FitsRow(const ExperimentOptions& experiment) {
  for (std::size_t i = 0; i < experiment.methods.size(); ++i) {
    const std::string& asked = experiment.figures.qualitative_method;
    const bool fits = asked.empty() ? experiment.methods[i].type != "oracle" : experiment.methods[i].name == asked;
    if (fits) return static_cast<int>(i);
  }
  return -1;
}

std::vector<std::size_t> FitsRows(const ExperimentOptions& experiment) {
  constexpr std::size_t kRows = 3;
  const FigureOptions& figures = experiment.figures;
  const bool one = !IsTwoView(experiment.task) || !figures.qualitative_method.empty();
  std::vector<std::size_t> rows;
  if (one && figures.qualitative_methods.empty()) {
    const int row = FitsRow(experiment);
    if (row >= 0) rows.push_back(row);
    return rows;
  }
  for (const std::string& name : figures.qualitative_methods) rows.push_back(experiment.RowOf(name));
  for (std::size_t m = 0; figures.qualitative_methods.empty() && m < experiment.methods.size(); ++m)
    if (experiment.methods[m].type != "oracle" && rows.size() < kRows) rows.push_back(m);
  return rows;
}

bool ShowsFits(const ExperimentOptions& experiment, std::size_t condition) {
  const auto& named = experiment.figures.qualitative_conditions;
  const auto& all = experiment.conditions;
  if (!named.empty()) return std::find(named.begin(), named.end(), all[condition].name) != named.end();
  const std::size_t shown = std::min<std::size_t>(4, all.size());
  for (std::size_t i = 0; i < shown; ++i) {
    const std::size_t at = shown == 1 ? 0 : i * (all.size() - 1) / (shown - 1);
    if (at == condition) return true;
  }
  return false;
}

bool ShowsTrace(const ExperimentOptions& experiment, std::size_t condition) {
  const std::string& named = experiment.figures.confidence_condition;
  return named.empty() ? condition == experiment.conditions.size() / 2 : experiment.conditions[condition].name == named;
}

std::vector<std::size_t> FitPositions(const ExperimentOptions& experiment, std::size_t problems) {
  const std::size_t count = std::min<std::size_t>(experiment.figures.qualitative, problems);
  const bool spread = IsTwoView(experiment.task);
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < count; ++i) positions.push_back(spread ? i * problems / count : i);
  return positions;
}

}  // namespace diffsac
