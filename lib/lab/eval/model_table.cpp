#include "lab/eval/tables.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "lab/data/point_files.h"
#include "lab/eval/format.h"

namespace diffsac {
namespace {

constexpr std::size_t kMostModels = 50;  // More are for files.

/// " m" behind numbers of one unit; nothing where it is not said, or conditions differ.
std::string UnitOf(const ExperimentOptions& experiment) {
  std::string unit;
  for (std::size_t c = 0; c < experiment.conditions.size(); ++c) {
    const Config& data = experiment.conditions[c].data;
    const std::string own = data.Has("unit") ? data.Text("unit") : "";
    if (c > 0 && own != unit) return "";
    unit = own;
  }
  return unit;
}

std::string InputText(const EstimateRecord& record) {
  if (record.status != Status::kOk) return record.id + " (no model: " + std::string(ToString(record.status)) + ")";
  return record.id + (record.MayBeChance() ? " (may be chance)" : "");
}

/// How many digits behind the point a value needs so that what is rounded off it is no more than a twentieth of
/// `change`; 16 where nothing is known of that.
int DigitsFor(double change, int least) {
  constexpr int kMost = 16;
  const double digits = change > 0.0 ? std::ceil(1.0 - std::log10(change)) : kMost;
  return static_cast<int>(std::clamp(digits, static_cast<double>(least), static_cast<double>(kMost)));
}

/// What two planes may differ by where points are, to be the same to all who look at these; nothing: not known.
std::optional<double> DistanceThatMatters(const EstimateRecord& record) {
  if (!std::isnan(record.sigma)) return record.sigma;
  if (record.inlier_threshold > 0.0) return 0.1 * record.inlier_threshold;
  return std::nullopt;
}

/// With so many digits behind the point, and at least 8 in all.
std::string OffsetText(double offset, int digits) {
  const int before = static_cast<int>(std::floor(std::log10(std::max(std::abs(offset), 1.0)))) + 1;
  return Format("%.*g", std::clamp(before + digits, 8, 17), offset);
}

/// Rows of one estimate.
class ModelRows {
 public:
  ModelRows(const ExperimentResults& results, Table* table)
      : experiment_(results.experiment),
        instances_(AnyRecord(results, [](const ProblemRecord& record) { return !record.instances.empty(); })),
        dimension_(static_cast<std::size_t>(PointDimension(results.experiment.task))),
        table_(*table) {
    auto& columns = table_.columns;
    columns = {"method", "points of"};
    if (experiment_.conditions.size() > 1) columns.push_back(experiment_.condition_label);
    if (instances_) columns.push_back("structure");
    for (std::size_t d = 0; d < dimension_; ++d) columns.push_back(std::string("normal ") + "xyz"[d]);
    columns.insert(columns.end(), {"offset d", "inliers", "of", "noise"});
  }

  void Add(const Cell& cell, const EstimateRecord& record) {
    const auto& models = record.instances;
    if (models.empty()) AddRow(cell, record, record.model, 1, record.inlier_rows.size());
    for (std::size_t k = 0; k < models.size(); ++k)
      AddRow(cell, record, models[k], k + 1,
             static_cast<std::size_t>(std::count(record.assignment.begin(), record.assignment.end(), k + 1)));
  }

 private:
  void AddRow(const Cell& cell, const EstimateRecord& record, const ModelParameters& model, std::size_t instance,
              std::size_t inliers) {
    Table::Row row{{experiment_.methods[cell.method].label, InputText(record)}, {}};
    auto& cells = row.cells;
    if (experiment_.conditions.size() > 1) cells.push_back(experiment_.conditions[cell.condition].label);
    const std::optional<double> change = DistanceThatMatters(record);
    const double farthest = record.largest_coordinate * std::sqrt(static_cast<double>(dimension_));
    const int digits = change ? DigitsFor(*change / farthest, 6) : 6, behind = change ? DigitsFor(*change, 0) : 0;
    const bool found = model.size() == static_cast<Eigen::Index>(dimension_) + 1;
    if (instances_) cells.push_back(found ? std::to_string(instance) : kUnknown);
    for (std::size_t d = 0; d < dimension_; ++d)
      cells.push_back(found ? FixedText(model[static_cast<Eigen::Index>(d)], digits) : kUnknown);
    cells.push_back(found ? OffsetText(model[static_cast<Eigen::Index>(dimension_)], behind) : kUnknown);
    cells.push_back(found ? std::to_string(inliers) : kUnknown);
    cells.push_back(std::to_string(record.points));
    cells.push_back(std::isnan(record.sigma) ? kUnknown : Format("%.3g", record.sigma));
    row.best.assign(cells.size(), false);
    table_.rows.push_back(std::move(row));
  }

  const ExperimentOptions& experiment_;
  bool instances_;
  std::size_t dimension_;
  Table& table_;
};

}  // namespace

Table ModelTable(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  Table table;
  if (!experiment.estimates || (experiment.task != Task::kLine && experiment.task != Task::kPlane)) return table;
  ModelRows rows(results, &table);
  for (const Cell& cell : results.cells) {
    if (!IsPointSets(experiment.conditions[cell.condition].data)) continue;
    for (const ProblemRecord& record : cell.records) rows.Add(cell, record);
  }
  const std::size_t all = table.rows.size();
  const std::string unit = UnitOf(experiment);
  table.heading = std::string(experiment.task == Task::kLine ? "lines" : "planes") +
                  " found: n · x + d = 0, |n| = 1; d and noise in " + (unit.empty() ? "the unit of the points" : unit);
  if (all > kMostModels) {
    table.rows.resize(kMostModels);
    table.heading += "; the first " + std::to_string(kMostModels) + " of " + std::to_string(all) +
                     ", problems.csv and estimates.h5 have all";
  }
  return table;
}

}  // namespace diffsac
