#include "lab/eval/report.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "lab/eval/format.h"
#include "lab/eval/problem_quantities.h"

namespace diffsac {
namespace {

std::string EdgeText(double edge) { return Format("%.6g", edge); }

/// The bins of numbers, named, without problems.
std::vector<Stratum> NumberBins(const StrataOptions& options) {
  const std::string by = ToString(options.by);
  const std::vector<double>& edges = options.bins;
  std::vector<Stratum> strata(edges.size() + 1);
  for (std::size_t i = 0; i < strata.size(); ++i) {
    const std::string from = i == 0 ? "" : EdgeText(edges[i - 1]), to = i == edges.size() ? "" : EdgeText(edges[i]);
    if (from.empty()) {
      strata[i].name = by + " below " + to;
      strata[i].label = "< " + to;
    } else if (to.empty()) {
      strata[i].name = by + " from " + from;
      strata[i].label = "≥ " + from;
    } else {
      strata[i].name = by + " " + from + "-" + to;
      strata[i].label = from + "–" + to;
    }
  }
  return strata;
}

std::vector<Stratum> SceneBins(const ExperimentResults& results) {
  std::vector<Stratum> strata;
  for (const Cell& cell : results.cells)
    for (const ProblemRecord& record : cell.records)
      if (std::none_of(strata.begin(), strata.end(), [&](const Stratum& s) { return s.label == record.scene; }))
        strata.push_back({ToString(Quantity::kScene) + " " + record.scene, record.scene, {}, {}});
  return strata;
}

/// Where a record belongs; the number of strata for none.
std::size_t PlaceOf(const ProblemRecord& record, const StrataOptions& options, const std::vector<Stratum>& strata) {
  if (options.by == Quantity::kScene)
    return static_cast<std::size_t>(
        std::find_if(strata.begin(), strata.end(), [&](const Stratum& s) { return s.label == record.scene; }) -
        strata.begin());
  const double value = QuantityOf(record, options.by);
  return std::isnan(value) ? strata.size() : BinOf(value, options.bins);
}

/// What results say of their run, without records and what is kept for pictures.
ExperimentResults WithoutRecords(const ExperimentResults& results) {
  ExperimentResults empty;
  empty.experiment = results.experiment;
  empty.dataset = results.dataset;
  for (const Cell& cell : results.cells) empty.cells.push_back({cell.condition, cell.method, {}});
  return empty;
}

}  // namespace

std::size_t BinOf(double value, const std::vector<double>& edges) {
  return static_cast<std::size_t>(std::upper_bound(edges.begin(), edges.end(), value) - edges.begin());
}

std::size_t ProblemsOf(const ExperimentResults& results, std::size_t condition) {
  std::set<std::uint64_t> indices;
  for (const Cell& cell : results.cells)
    if (cell.condition == condition)
      for (const ProblemRecord& record : cell.records) indices.insert(record.index);
  return indices.size();
}

std::vector<Stratum> StrataOf(const ExperimentResults& results, const StrataOptions& options) {
  std::vector<Stratum> strata = options.by == Quantity::kScene ? SceneBins(results) : NumberBins(options);
  for (Stratum& stratum : strata) stratum.results = WithoutRecords(results);
  for (std::size_t i = 0; i < results.cells.size(); ++i)
    for (const ProblemRecord& record : results.cells[i].records) {
      const std::size_t place = PlaceOf(record, options, strata);
      if (place == strata.size()) continue;
      ProblemRecord& kept = strata[place].results.cells[i].records.emplace_back(record);
      kept.scene = "all";
      for (auto* list : {&kept.inlier_rows, &kept.rows, &kept.assignment}) *list = {};
      kept.inlier_probabilities = {};
    }
  for (Stratum& stratum : strata)
    for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c)
      stratum.problems.push_back(ProblemsOf(stratum.results, c));
  return strata;
}

}  // namespace diffsac
