#include "lab/eval/terminal_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <ostream>

#include "lab/data/point_files.h"
#include "lab/eval/format.h"

namespace diffsac {
namespace {

constexpr const char* kUnknown = "-";

using Lines = std::vector<std::vector<std::string>>;

std::size_t Width(const std::string& text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
}

/// The first columns, `left` of them, on the left; numbers on the right.
void PrintLines(const Lines& lines, std::size_t left, std::ostream& out) {
  std::vector<std::size_t> widths(lines.front().size(), 0);
  for (const auto& line : lines)
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], Width(line[i]));
  for (const auto& line : lines) {
    std::string text;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::string padding(widths[i] - Width(line[i]), ' ');
      text += (i == 0 ? "" : "  ") + (i < left ? line[i] + padding : padding + line[i]);
    }
    out << text.substr(0, text.find_last_not_of(' ') + 1) << "\n";
  }
}

std::string FixedText(double value, int digits) { return std::isnan(value) ? kUnknown : FixedNumber(value, digits); }

/// The unweighted mean over the scenes of what `of` makes of a scene's known values.
template <class Value, class Of>
double OverScenes(const Cell& cell, const Value& value, const Of& of) {
  std::map<std::string, std::vector<double>> scenes;
  for (const ProblemRecord& record : cell.records)
    if (const double one = value(record); !std::isnan(one)) scenes[record.scene].push_back(one);
  std::vector<double> values;
  for (auto& [scene, all] : scenes) values.push_back(of(all));
  return Mean(values);
}

/// What the table shows.
struct Shown {
  bool truth, instances, median;
  Tolerance c;
};

Shown ShownOf(const ExperimentResults& results) {
  const Tolerance c = results.experiment.tolerance();
  const bool instances = JudgesInstances(results);
  const bool truth = AnyRecord(results, [&](const ProblemRecord& r) { return !std::isnan(AccuracyOf(r.error, c)); });
  const Task task = results.experiment.task;
  return {truth, instances, truth && !instances && (task == Task::kLine || task == Task::kPlane), c};
}

std::string HeadingOf(const Shown& shown) {
  if (!shown.truth) return "median inliers (no ground truth)";
  if (shown.instances) return "recall of structures";
  return MetricName("mAA", shown.c) + (shown.median ? ", median error in degrees" : "");
}

std::string CellText(const Cell& cell, const Shown& shown) {
  const auto median = [](const std::vector<double>& values) { return Median(values); };
  const auto mean = [](const std::vector<double>& values) { return Mean(values); };
  std::vector<double> milliseconds;
  for (const ProblemRecord& record : cell.records) milliseconds.push_back(record.stats.ms_total);
  std::string text = shown.truth
                         ? FixedText(OverScenes(
                                         cell, [&](const auto& r) { return AccuracyOf(r.error, shown.c); }, mean),
                                     3)
                         : FixedText(OverScenes(
                                         cell, [](const auto& r) { return double(r.inliers); }, median),
                                     0);
  if (shown.median)
    text += " " + FixedText(OverScenes(
                                cell, [&](const auto& r) { return MainError(r.error, shown.c); }, median),
                            3);
  const double ms = Median(milliseconds);
  return text + " " + (std::isnan(ms) ? kUnknown : ms < 100.0 ? Format("%6.3g", ms) : Format("%6.0f", ms));
}

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

/// How many digits behind the point a value needs so that what is rounded off it is no more than a twentieth of
/// `change`; 16 where nothing is known of that.
int DigitsFor(double change, int least) {
  constexpr int kMost = 16;
  const double digits = change > 0.0 ? std::ceil(1.0 - std::log10(change)) : kMost;
  return static_cast<int>(std::clamp(digits, static_cast<double>(least), static_cast<double>(kMost)));
}

/// n, d, inliers, points and noise, with the digits that two planes may differ by where points are, to be the same to
/// all who look at these.
std::vector<std::string> ModelTexts(const EstimateRecord& record, const ModelParameters& model, std::size_t inliers) {
  const Eigen::Index dimension = model.size() - 1;
  const double change = !std::isnan(record.sigma) ? record.sigma : 0.1 * record.inlier_threshold;
  const double farthest = record.largest_coordinate * std::sqrt(static_cast<double>(dimension));
  const bool known = !std::isnan(change) && (!std::isnan(record.sigma) || change > 0.0);
  const int digits = known ? DigitsFor(change / farthest, 6) : 6, behind = known ? DigitsFor(change, 0) : 0;
  const int before = static_cast<int>(std::floor(std::log10(std::max(std::abs(model[dimension]), 1.0)))) + 1;
  std::vector<std::string> texts;
  for (Eigen::Index d = 0; d < dimension; ++d) texts.push_back(FixedText(model[d], digits));
  texts.push_back(Format("%.*g", std::clamp(before + behind, 8, 17), model[dimension]));
  texts.insert(texts.end(), {std::to_string(inliers), std::to_string(record.points),
                             std::isnan(record.sigma) ? kUnknown : Format("%.3g", record.sigma)});
  return texts;
}

void AddModels(const ExperimentResults& results, const Cell& cell, const ProblemRecord& record, Lines* lines) {
  std::string name = record.id + (record.MayBeChance() ? " (may be chance)" : "");
  if (record.status != Status::kOk) name += " (no model: " + std::string(ToString(record.status)) + ")";
  const std::vector<std::string> begin = {results.experiment.methods[cell.method].label,
                                          results.experiment.conditions[cell.condition].label, name};
  const bool one = record.instances.empty();
  const std::vector<ModelParameters> models = one ? std::vector{record.model} : record.instances;
  for (std::size_t k = 0; k < models.size(); ++k) {
    std::vector<std::string>& line = lines->emplace_back(begin);
    const auto inliers = one ? record.inlier_rows.size()
                             : static_cast<std::size_t>(std::count(record.assignment.begin(), record.assignment.end(),
                                                                   static_cast<std::int32_t>(k + 1)));
    const std::vector<std::string> texts =
        models[k].size() > 0 ? ModelTexts(record, models[k], inliers) : std::vector<std::string>();
    line.insert(line.end(), texts.begin(), texts.end());
    line.resize(lines->front().size(), kUnknown);
  }
}

/// The lines or planes that were found in a person's own points, a row a model.
void PrintModels(const ExperimentResults& results, std::ostream& out) {
  constexpr std::size_t kMostModels = 50;  // More are for files.
  const ExperimentOptions& experiment = results.experiment;
  if (experiment.task != Task::kLine && experiment.task != Task::kPlane) return;
  Lines lines = {{"method", "data", "points of", "normal x", "normal y"}};
  if (experiment.task == Task::kPlane) lines.front().emplace_back("normal z");
  lines.front().insert(lines.front().end(), {"offset d", "inliers", "of", "noise"});
  for (const Cell& cell : results.cells) {
    if (!experiment.estimates || !IsPointSets(experiment.conditions[cell.condition].data)) continue;
    for (const ProblemRecord& record : cell.records) AddModels(results, cell, record, &lines);
  }
  const std::size_t all = lines.size() - 1;
  if (all == 0) return;
  const bool one = experiment.conditions.size() == 1;
  for (std::vector<std::string>& line : lines)
    if (one) line.erase(line.begin() + 1);
  const std::string unit = UnitOf(experiment);
  out << "\n"
      << (experiment.task == Task::kLine ? "lines" : "planes") << " found: n · x + d = 0, |n| = 1; d and noise in "
      << (unit.empty() ? "the unit of the points" : unit);
  if (all > kMostModels)
    out << "; the first " << kMostModels << " of " << all << ", problems.csv and estimates.h5 have all";
  lines.resize(std::min(lines.size(), kMostModels + 1));
  out << "\n";
  PrintLines(lines, one ? 2 : 3, out);
}

}  // namespace

std::string MetricName(const std::string& metric, const Tolerance& tolerance) {
  return Format("%s@%g%s", metric.c_str(), tolerance.value, tolerance.pixels ? "px" : "deg");
}

void PrintTable(const ExperimentResults& results, std::ostream& out) {
  constexpr std::size_t kAcross = 5;  // Conditions beside each other.
  const ExperimentOptions& experiment = results.experiment;
  const Shown shown = ShownOf(results);
  std::size_t problems = 0;
  for (const Cell& cell : results.cells) problems = std::max(problems, cell.records.size());
  out << experiment.name << ": " << HeadingOf(shown) << ", milliseconds; " << problems << " problems, seed "
      << experiment.seed << (results.partial ? "; PARTIAL, the run was interrupted" : "") << "\n";
  for (std::size_t first = 0; first < experiment.conditions.size(); first += kAcross) {
    const std::size_t end = std::min(first + kAcross, experiment.conditions.size());
    Lines lines = {{"method"}};
    for (std::size_t c = first; c < end; ++c) lines.front().push_back(experiment.conditions[c].label);
    for (std::size_t m = 0; m < experiment.methods.size(); ++m) {
      lines.push_back({experiment.methods[m].label});
      lines.back().resize(1 + end - first);
    }
    for (const Cell& cell : results.cells)
      if (cell.condition >= first && cell.condition < end)
        lines[1 + cell.method][1 + cell.condition - first] = CellText(cell, shown);
    PrintLines(lines, 1, out);
  }
  PrintModels(results, out);
}

}  // namespace diffsac
