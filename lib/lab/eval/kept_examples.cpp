#include "lab/eval/kept_examples.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity.
Json NumberJson(double value) {
  return std::isfinite(value) ? Json(value) : std::isinf(value) ? Json("inf") : Json(nullptr);
}

template <class Values>
Json NumbersJson(const Values& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(NumberJson(value));
  return list;
}

Json ExampleJson(const KeptExample& kept) {
  const Example& example = kept.example;
  const Problem& problem = example.problem;
  const auto [image1, image2] = ImageNames(example);
  Json json = {{"condition", kept.condition},
               {"index", example.index},
               {"id", example.id},
               {"name", ProblemName(example)},
               {"scene", example.scene},
               {"folder", kept.folder},
               {"image1", image1},
               {"image2", image2},
               {"size1", {problem.size1.width, problem.size1.height}},
               {"size2", {problem.size2.width, problem.size2.height}},
               {"inlier_threshold", NumberJson(problem.inlier_threshold)},
               {"true_model", NumbersJson(example.truth.model)}};
  if (!kept.path.empty()) json.update({{"path", kept.path}, {"name_in_file", kept.name_in_file}});
  if (example.truth.instances.empty()) return json;
  json["true_models"] = Json::array();
  for (const ModelParameters& model : example.truth.instances) json["true_models"].push_back(NumbersJson(model));
  json["true_labels"] = example.truth.assignment;
  return json;
}

Json TraceJson(const KeptTrace& kept, const ExperimentResults& results) {
  Json steps = Json::array();
  for (const std::vector<float>& confidence : kept.trace.confidence) steps.push_back(NumbersJson(confidence));
  return {{"condition", kept.condition},
          {"index", kept.index},
          {"method", results.experiment.methods[kept.method].name},
          {"set_size", MinimalSetSize(results.experiment.task)},
          {"timesteps", kept.trace.timesteps},
          {"confidence", std::move(steps)}};
}

void PutPoints(const H5::Group& group, const std::string& name, const PointMatrix& points) {
  if (points.size() == 0) return;
  WriteNumbers(group, name, points.data(), {static_cast<hsize_t>(points.rows()), static_cast<hsize_t>(points.cols())});
}

}  // namespace

std::vector<std::size_t> ExamplePositions(const ExperimentOptions& experiment, std::size_t problems) {
  const std::size_t count = std::min(static_cast<std::size_t>(experiment.examples), problems);
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < count; ++i) positions.push_back(IsTwoView(experiment.task) ? i * problems / count : i);
  return positions;
}

void ExampleKeeper::Keep(std::size_t condition, const Example& example, const Dataset& dataset) {
  constexpr std::size_t kMostBytes = std::size_t{256} << 20;
  const std::size_t bytes = static_cast<std::size_t>(example.problem.points.size()) * sizeof(double);
  if (bytes_ + bytes > kMostBytes) {
    if (bytes_ < kMostBytes)
      LogInfo("points of " + std::to_string(examples_.size()) + " problems are kept for pictures, more have no room");
    bytes_ = kMostBytes;
    return;
  }
  bytes_ += bytes;
  KeptExample kept{condition, example, dataset.FolderOf(example.scene), "", "", {}};
  if (const auto* sources = dynamic_cast<const HasPointSources*>(&dataset))
    AddSource(sources->SourceOf(example.index), &kept);
  examples_.push_back(std::move(kept));
}

void ExampleKeeper::AddSource(const PointSource& source, KeptExample* kept) {
  kept->path = source.path;
  kept->name_in_file = source.name;
  if (source.rows.empty()) return;
  try {
    if (source.path != path_) sets_ = ReadPointFile(path_ = source.path);
    const auto set = std::find_if(sets_.begin(), sets_.end(), [&](const PointSet& one) {
      return one.name == source.name && one.points.rows() == source.total;
    });
    if (set == sets_.end()) throw Error(source.path + ": other points than before");
    kept->source = set->points;
    bytes_ += static_cast<std::size_t>(kept->source.size()) * sizeof(double);
  } catch (const Error& error) {
    LogWarning("points that were left out get no labels: " + std::string(error.what()));
  }
}

std::pair<std::string, std::string> ImageNames(const Example& example) {
  if (!example.image1.empty()) return {example.image1, example.image2};
  const std::string pair = example.id.substr(example.id.rfind('/') + 1);
  const std::size_t dash = pair.find('-');
  if (dash == std::string::npos) return {};
  return {pair.substr(0, dash), pair.substr(dash + 1)};
}

void PutExamples(const ExperimentResults& results, H5::H5File& file) {
  if (results.examples.empty()) return;
  const H5::Group group = file.createGroup(kExamplesGroup);
  Json examples = Json::array(), traces = Json::array();
  std::map<std::pair<std::size_t, std::uint64_t>, std::size_t> numbers;
  for (const KeptExample& kept : results.examples) {
    const Problem& problem = kept.example.problem;
    const std::string number = "-" + std::to_string(examples.size());
    numbers[{kept.condition, kept.example.index}] = examples.size();
    examples.push_back(ExampleJson(kept));
    PutPoints(group, "points" + number, problem.points);
    if (!IsTwoView(problem.task)) PutPoints(group, "image_points" + number, ImagePoints(problem));
    PutPoints(group, "source" + number, kept.source);
    const std::vector<std::uint8_t>& inliers = kept.example.truth.inliers;
    if (!inliers.empty()) WriteNumbers(group, "inliers" + number, inliers.data(), {inliers.size()});
  }
  for (const KeptTrace& trace : results.traces) {
    const auto number = numbers.find({trace.condition, trace.index});
    if (number == numbers.end()) continue;
    traces.push_back(TraceJson(trace, results));
    traces.back()["example"] = number->second;
  }
  const std::string text =
      Json{{"examples", examples}, {"traces", traces}}.dump(-1, ' ', false, Json::error_handler_t::replace);
  WriteNumbers(group, "json", text.data(), {text.size()});
}

}  // namespace diffsac
