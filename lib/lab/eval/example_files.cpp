#include "lab/eval/example_files.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <numeric>
#include <tuple>

#include "diffsac/core/logging.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_factory.h"
#include "lab/eval/instances_error.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_output.h"

namespace diffsac {
namespace {

using Json = nlohmann::ordered_json;

// What a page may take for pictures of pairs: in all, and for their matches, in bytes of the page.
constexpr std::size_t kMostPairs = 1000;
constexpr double kMostMatchBytes = 15e6;

/// JSON has no infinity.
Json NumberJson(double value) {
  return std::isfinite(value) ? Json(value) : std::isinf(value) ? Json("inf") : Json(nullptr);
}

Json ModelJson(const ModelParameters& model) {
  Json values = Json::array();
  for (const double value : model) values.push_back(NumberJson(value));
  return values;
}

Json ModelsJson(const std::vector<ModelParameters>& models) {
  Json list = Json::array();
  for (const ModelParameters& model : models) list.push_back(ModelJson(model));
  return list;
}

/// A file while it is gathered.
class ExampleFile {
 public:
  /// The example's number; one that is there already keeps its own. `folder`: its scene's.
  std::size_t Add(const Example& example, std::size_t condition, const std::string& folder) {
    const auto [at, is_new] = numbers_.try_emplace({condition, example.index}, examples_.size());
    if (!is_new) return at->second;
    const auto [image1, image2] = ImageNames(example);
    const Problem& problem = example.problem;
    examples_.push_back({{"condition", condition},
                         {"index", example.index},
                         {"id", example.id},
                         {"name", ProblemName(example)},
                         {"scene", example.scene},
                         {"folder", folder},
                         {"image1", image1},
                         {"image2", image2},
                         {"size1", {problem.size1.width, problem.size1.height}},
                         {"size2", {problem.size2.width, problem.size2.height}}});
    points_.push_back(problem.points);
    inliers_.push_back(example.truth.inliers);
    return at->second;
  }

  void Put(const char* key, Json value) { more_[key] = std::move(value); }

  void Write(const std::string& path) const {
    Json json = {{"examples", examples_}};
    json.update(more_);
    const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    WriteHdf5(path, [&](Hdf5Output& file) {
      file.Put("json", text.data(), {text.size()});
      for (std::size_t i = 0; i < points_.size(); ++i) {
        const PointMatrix& points = points_[i];
        const auto rows = static_cast<hsize_t>(points.rows()), columns = static_cast<hsize_t>(points.cols());
        file.Put("points-" + std::to_string(i), points.data(), {rows, columns});
        if (!inliers_[i].empty()) file.Put("inliers-" + std::to_string(i), inliers_[i].data(), {inliers_[i].size()});
      }
    });
  }

 private:
  Json examples_ = Json::array(), more_ = Json::object();
  std::map<std::pair<std::size_t, std::uint64_t>, std::size_t> numbers_;
  std::vector<PointMatrix> points_;
  std::vector<std::vector<std::uint8_t>> inliers_;
};

Json ErrorJson(const EstimateError& error) {
  return {{"failed", error.failed},
          {"angle_deg", NumberJson(error.angle_deg)},
          {"rotation_deg", NumberJson(error.rotation_deg)},
          {"translation_deg", NumberJson(error.translation_deg)},
          {"error_px", NumberJson(error.error_px)},
          {"recall", NumberJson(error.recall)},
          {"misclassified", NumberJson(error.misclassified)}};
}

Json FitJson(const KeptFit& fit, const Tolerance& tolerance) {
  const Example& example = fit.example;
  const Estimate& estimate = fit.estimate;
  const EstimateError error = MeasureError(estimate, example);
  Json json = {{"method", fit.method},
               {"condition", fit.condition},
               {"status", std::string(ToString(estimate.status))},
               {"inliers", estimate.inliers},
               {"model", ModelJson(estimate.model)},
               {"true_model", ModelJson(example.truth.model)},
               {"shown_error", NumberJson(ShownError(error, tolerance))},
               {"error", ErrorJson(error)}};
  if (estimate.instances.empty() && example.truth.instances.empty()) return json;
  const EstimatedInstances found = InstancesOf(estimate, example.problem);
  json["structures"] = {{"models", ModelsJson(found.models)},
                        {"labels", found.assignment},
                        {"true_models", ModelsJson(example.truth.instances)}};
  if (static_cast<Eigen::Index>(example.truth.assignment.size()) == example.problem.points.rows())
    json["structures"]["true_labels"] = AlignedTruth(found.assignment, example.truth.assignment);
  return json;
}

/// Its points where they are in the image, of problems that have one.
Example InTheImage(Example example) {
  const PointMatrix points = ImagePoints(example.problem);
  if (points.size() > 0) example.problem.points = points;
  return example;
}

/// Matches and segments are drawn from one end to the other.
bool HasTwoEnds(Task task) { return IsTwoView(task) || task == Task::kVanishingPoint; }

Json TraceJson(const KeptTrace& kept) {
  Json steps = Json::array();
  for (const std::vector<float>& confidence : kept.trace.confidence) {
    steps.push_back(Json::array());
    for (const float value : confidence) steps.back().push_back(NumberJson(value));
  }
  return {{"timesteps", kept.trace.timesteps},
          {"confidence", std::move(steps)},
          {"set_size", MinimalSetSize(kept.example.problem.task)},
          {"downwards", ImagePoints(kept.example.problem).size() > 0}};
}

std::string PathIn(const std::string& folder, const char* name) {
  return (std::filesystem::path(folder) / name).string();
}

/// A problem of one condition, which several methods were run on.
struct Listed {
  std::size_t condition = 0;
  const ProblemRecord* record = nullptr;  ///< Of one of them.
  double error = std::nan("");            ///< Of the row that ranks them.
  bool drawable = false;                  ///< Some method's inliers were kept.
};

std::size_t RankingRow(const ExperimentOptions& experiment) {
  const int reference = ReferenceRow(experiment);
  if (reference >= 0) return static_cast<std::size_t>(reference);
  for (std::size_t m = 0; m < experiment.methods.size(); ++m)
    if (experiment.methods[m].Competes()) return m;
  return 0;
}

/// Conditions one after the other, each as its data has its problems.
std::vector<Listed> ListProblems(const ExperimentResults& results) {
  const std::size_t ranking = RankingRow(results.experiment);
  std::map<std::pair<std::size_t, std::uint64_t>, Listed> problems;
  for (const Cell& cell : results.cells) {
    for (const ProblemRecord& record : cell.records) {
      Listed& problem =
          problems.try_emplace({cell.condition, record.index}, Listed{cell.condition, &record}).first->second;
      if (cell.method == ranking) problem.error = ShownError(record.error, results.experiment.tolerance());
      problem.drawable = results.experiment.estimates;
    }
  }
  for (const KeptFit& fit : results.fits) {
    const auto at = problems.find({fit.condition, fit.example.index});
    if (at != problems.end()) at->second.drawable = true;
  }
  std::vector<Listed> list;
  for (auto& [place, problem] : problems) list.push_back(std::move(problem));
  return list;
}

/// How many pictures have room, by the average number of matches: of each 64 bits for its place, one for each mask.
std::size_t MostPictures(const ExperimentResults& results, const std::vector<Listed>& list) {
  double bytes = 0.0;
  const double bits = 64.0 + 1.0 + static_cast<double>(results.experiment.methods.size());
  for (const Listed& problem : list) bytes += 4.0 / 3.0 * bits / 8.0 * problem.record->points + 200.0;
  const double each = bytes / static_cast<double>(std::max<std::size_t>(1, list.size()));
  return std::min(kMostPairs, static_cast<std::size_t>(kMostMatchBytes / std::max(each, 1.0)));
}

std::vector<Listed> ShownProblems(const ExperimentResults& results) {
  std::vector<Listed> list = ListProblems(results), shown;
  const std::size_t most = MostPictures(results, list);
  std::erase_if(list, [](const Listed& problem) { return !problem.drawable; });
  std::vector<double> errors;
  for (const Listed& problem : list) errors.push_back(problem.error);
  for (const std::size_t i : LargestSmallestAndSpread(errors, most)) shown.push_back(std::move(list[i]));
  return shown;
}

void AddPairs(const ExperimentResults& results, ExampleFile* file) {
  std::unique_ptr<Dataset> dataset;
  std::size_t condition = results.experiment.conditions.size();
  for (const Listed& problem : ShownProblems(results)) {
    if (condition != problem.condition) {
      condition = problem.condition;
      dataset = MakeDataset(results.experiment.conditions[condition].data, results.experiment.seed);
    }
    const Example example = dataset->Get(problem.record->index);
    // The data may have changed since shards ran.
    if (ProblemName(example) == problem.record->id && example.problem.points.rows() == problem.record->points)
      file->Add(example, condition, dataset->FolderOf(example.scene));
  }
}

}  // namespace

std::pair<std::string, std::string> ImageNames(const Example& example) {
  if (!example.image1.empty()) return {example.image1, example.image2};
  const std::string pair = example.id.substr(example.id.rfind('/') + 1);
  const std::size_t dash = pair.find('-');
  if (dash == std::string::npos) return {};
  return {pair.substr(0, dash), pair.substr(dash + 1)};
}

void WriteFits(const ExperimentResults& results, const std::string& folder) {
  const std::string path = PathIn(folder, kFitsFile);
  if (results.fits.empty() && results.traces.empty()) return RemoveFile(path);
  ExampleFile file;
  Json fits = Json::array(), traces = Json::array();
  for (const KeptFit& fit : results.fits) {
    const bool two_ends = HasTwoEnds(fit.example.problem.task);
    Json json = FitJson(fit, results.experiment.tolerance());
    json["example"] = file.Add(two_ends ? fit.example : InTheImage(fit.example), fit.condition, fit.folder);
    json["downwards"] = ImagePoints(fit.example.problem).size() > 0;
    fits.push_back(std::move(json));
  }
  // As of a condition of its own: its points may be others than those of a fit.
  for (const KeptTrace& kept : results.traces) {
    traces.push_back(TraceJson(kept));
    traces.back()["example"] = file.Add(InTheImage(kept.example), results.experiment.conditions.size(), "");
  }
  file.Put("fits_label", results.fits_label);
  file.Put("qualitative", results.experiment.figures.qualitative);
  file.Put("fits", std::move(fits));
  file.Put("traces", std::move(traces));
  file.Write(path);
}

void WritePairs(const ExperimentResults& results, const std::string& folder) {
  const std::string path = PathIn(folder, kPairsFile);
  RemoveFile(path);
  if (!results.experiment.report || !IsTwoView(results.experiment.task)) return;
  ExampleFile file;
  try {
    AddPairs(results, &file);
  } catch (const std::exception& error) {
    return LogWarning("report.html has no pictures of the pairs: " + std::string(error.what()));
  }
  file.Write(path);
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

}  // namespace diffsac
