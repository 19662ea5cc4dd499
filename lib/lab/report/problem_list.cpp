#include "lab/report/problem_list.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>

#include "lab/report/pair_text.h"

namespace diffsac {
namespace {

using Json = nlohmann::ordered_json;

std::string Dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

constexpr std::size_t kMostDetails = 2000;  // Of more lines only those with a picture have a model in the page.

// Short: there are many of them. JSON has no infinity.
std::string JsonNumber(double value) {
  if (std::isnan(value)) return "null";
  if (std::isinf(value)) return "\"inf\"";
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

std::size_t RankingEstimator(const ExperimentOptions& experiment) {
  const int reference = ReferenceRow(experiment);
  if (reference >= 0) return static_cast<std::size_t>(reference);
  for (std::size_t m = 0; m < experiment.methods.size(); ++m)
    if (experiment.methods[m].Competes()) return m;
  return 0;
}

template <class Of>
Json LabelsJson(const std::vector<Of>& rows) {
  Json labels = Json::array();
  for (const Of& row : rows) labels.push_back(row.label.empty() ? row.name : row.label);
  return labels;
}

/// Names by number, each once.
class Names {
 public:
  std::size_t Number(const std::string& name) {
    const auto [at, is_new] = numbers_.try_emplace(name, names_.size());
    if (is_new) names_.push_back(name);
    return at->second;
  }
  Json ToJson() const { return names_; }

 private:
  std::map<std::string, std::size_t> numbers_;
  std::vector<std::string> names_;
};

std::string StatusText(const ProblemRecord& record) {
  return std::string(ToString(record.status)) + (record.MayBeChance() ? ", may be chance" : "");
}

std::string LineJson(const ProblemRecord& record, std::size_t problem, std::size_t method, std::size_t status,
                     const ExperimentOptions& experiment, const MetricKinds& kinds) {
  std::string line = "[" + std::to_string(problem) + "," + std::to_string(method) + "," + std::to_string(status) + "," +
                     JsonNumber(ShownError(record.error, experiment.tolerance()));
  if (kinds.poses) line += "," + JsonNumber(record.error.rotation_deg) + "," + JsonNumber(record.error.translation_deg);
  if (kinds.structures) line += "," + JsonNumber(record.error.recall) + "," + std::to_string(record.structures);
  return line + "," + std::to_string(record.inliers) + "," + std::to_string(record.report.hypotheses) + "," +
         JsonNumber(record.report.ms_total) + "]";
}

/// What the problem's picture, or its line, opens beside the numbers of the list.
std::string DetailsJson(const EstimateRecord& estimate, Task task) {
  Json json = {{"noise", nullptr}, {"model", nullptr}, {"pose", nullptr}};
  const auto put = [&](const char* key, const auto& values) {
    for (const double value : values) json[key].push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
  };
  if (std::isfinite(estimate.noise_scale)) json["noise"] = estimate.noise_scale;
  if (estimate.model.size() > 0) put("model", estimate.model);
  if (estimate.pose)
    for (int row = 0; row < 3; ++row) {
      put("pose", estimate.pose->rotation.row(row));
      json["pose"].push_back(estimate.pose->translation[row]);
    }
  if (IsUndetermined(estimate.translation)) json["undetermined"] = UndeterminedText(estimate.translation, task);
  return Dump(json);
}

bool HasDetails(const EstimateRecord& estimate) {
  return estimate.model.size() > 0 || std::isfinite(estimate.noise_scale);
}

std::vector<double> ErrorsOf(const Cell& cell, const Tolerance& tolerance) {
  std::vector<double> errors;
  for (const ProblemRecord& record : cell.records) errors.push_back(ShownError(record.error, tolerance));
  return errors;
}

}  // namespace

std::size_t ProblemList::At(std::size_t condition, std::uint64_t index) const {
  const auto begin = problems.begin() + static_cast<std::ptrdiff_t>(first_[condition]);
  const auto end = problems.begin() + static_cast<std::ptrdiff_t>(first_[condition + 1]);
  const auto at = std::lower_bound(begin, end, index,
                                   [](const ListedProblem& problem, std::uint64_t i) { return problem.index < i; });
  return static_cast<std::size_t>(at - problems.begin());
}

ProblemList ListProblems(const ExperimentResults& results) {
  ProblemList list;
  list.method = RankingEstimator(results.experiment);
  for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c) {
    list.first_.push_back(list.problems.size());
    std::map<std::uint64_t, ListedProblem> problems;
    for (const Cell& cell : results.cells) {
      if (cell.condition != c) continue;
      for (const ProblemRecord& record : cell.records) {
        ListedProblem& problem = problems
                                     .try_emplace(record.index, ListedProblem{c, record.index, record.id, record.scene,
                                                                              record.points, std::nan("")})
                                     .first->second;
        if (cell.method == list.method) problem.error = ShownError(record.error, results.experiment.tolerance());
      }
    }
    for (auto& [index, problem] : problems) list.problems.push_back(std::move(problem));
  }
  list.first_.push_back(list.problems.size());
  return list;
}

std::vector<std::size_t> LargestSmallestAndSpread(const std::vector<double>& errors, std::size_t most) {
  std::vector<std::size_t> order(errors.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (errors.size() <= most) return order;
  const auto rank = [&](std::size_t i) { return std::isnan(errors[i]) ? -1.0 : errors[i]; };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) > rank(b); });
  const std::size_t largest = most - most / 2, smallest = most / 4, spread = most - largest - smallest;
  const std::size_t between = errors.size() - largest - smallest;
  std::vector<std::size_t> chosen(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(largest));
  for (std::size_t i = 0; i < spread; ++i) chosen.push_back(order[largest + i * between / spread]);
  chosen.insert(chosen.end(), order.end() - static_cast<std::ptrdiff_t>(smallest), order.end());
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

std::string ProblemListJson(const ExperimentResults& results, const ProblemList& list, const PictureNumbers& pictures,
                            std::size_t most_lines, std::size_t* left_out) {
  const ExperimentOptions& experiment = results.experiment;
  const MetricKinds kinds{JudgesPoses(results), JudgesStructures(results)};
  const std::size_t most_of_cell =
      std::max<std::size_t>(8, most_lines / std::max<std::size_t>(1, results.cells.size()));
  std::size_t records = 0;
  for (const Cell& cell : results.cells) records += cell.records.size();
  Names scenes, statuses;
  std::string lines, problems, details;
  std::size_t line = 0;
  *left_out = 0;
  for (const Cell& cell : results.cells) {
    const auto chosen = LargestSmallestAndSpread(ErrorsOf(cell, experiment.tolerance()), most_of_cell);
    *left_out += cell.records.size() - chosen.size();
    for (const std::size_t i : chosen) {
      const ProblemRecord& record = cell.records[i];
      const std::size_t problem = list.At(cell.condition, record.index);
      const std::size_t status = statuses.Number(StatusText(record));
      lines += (lines.empty() ? "" : ",\n") + LineJson(record, problem, cell.method, status, experiment, kinds);
      const bool shown = records <= kMostDetails || (!pictures.empty() && pictures[problem] >= 0);
      if (shown && i < cell.estimates.size() && HasDetails(cell.estimates[i]))
        details += (details.empty() ? "\"" : ",\n\"") + std::to_string(line) +
                   "\":" + DetailsJson(cell.estimates[i], results.experiment.task);
      ++line;
    }
  }
  for (std::size_t i = 0; i < list.problems.size(); ++i) {
    const ListedProblem& problem = list.problems[i];
    problems += (i == 0 ? "[" : ",\n[") + Dump(problem.id) + "," + std::to_string(scenes.Number(problem.scene)) + "," +
                std::to_string(problem.condition) + "," + std::to_string(problem.points) + "," +
                std::to_string(pictures.empty() ? -1 : pictures[i]) + "]";
  }
  return "{\"task\":" + Dump(ToString(experiment.task)) +
         ",\"unit\":" + Dump(ShownUnit(kinds.structures, experiment.tolerance())) +
         ",\"poses\":" + (kinds.poses ? "true" : "false") + ",\"structures\":" + (kinds.structures ? "true" : "false") +
         ",\"two_view\":" + (IsTwoView(experiment.task) ? "true" : "false") +
         ",\"method\":" + std::to_string(list.method) + ",\"condition_label\":" + Dump(experiment.condition_label) +
         ",\"methods\":" + Dump(LabelsJson(experiment.methods)) +
         ",\"conditions\":" + Dump(LabelsJson(experiment.conditions)) + ",\"scenes\":" + Dump(scenes.ToJson()) +
         ",\"statuses\":" + Dump(statuses.ToJson()) + ",\n\"problems\":[" + problems + "],\n\"details\":{" + details +
         "},\n\"lines\":[" + lines + "]}";
}

}  // namespace diffsac
