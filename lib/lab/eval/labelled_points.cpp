#include "lab/eval/labelled_points.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/config/dataset_factory.h"
#include "lab/data/point_files.h"
#include "lab/eval/colours.h"
#include "lab/eval/format.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

double DistanceTo(const ModelParameters& model, const PointMatrix& points, Eigen::Index i) {
  const Eigen::Index dimension = points.cols();
  return std::abs(points.row(i).dot(model.head(dimension)) + model[dimension]);
}

/// The nearest model within `threshold`, counted from 1; 0 for none, and for points that are not finite.
std::int32_t NearestModel(const std::vector<ModelParameters>& models, const PointMatrix& points, Eigen::Index i,
                          double threshold) {
  std::int32_t label = 0;
  double least = threshold;
  for (std::size_t k = 0; k < models.size(); ++k) {
    const double distance = DistanceTo(models[k], points, i);
    if (!(distance <= least)) continue;
    least = distance;
    label = static_cast<std::int32_t>(k) + 1;
  }
  return label;
}

/// The labels of the problem's own points.
std::vector<std::int32_t> ProblemLabels(const EstimateRecord& record) {
  if (!record.assignment.empty()) return record.assignment;
  std::vector<std::int32_t> labels(static_cast<std::size_t>(record.points), 0);
  for (const std::int32_t i : record.inlier_rows) labels[static_cast<std::size_t>(i)] = 1;
  return labels;
}

std::vector<std::uint8_t> UsedPoints(Eigen::Index points, const std::vector<std::int32_t>& rows) {
  std::vector<std::uint8_t> used(static_cast<std::size_t>(points), rows.empty() ? 1 : 0);
  for (const std::int32_t row : rows) used[static_cast<std::size_t>(row)] = 1;
  return used;
}

template <class Value>
void AppendBytes(Value value, std::string* bytes) {
  char raw[sizeof(Value)];
  std::memcpy(raw, &value, sizeof(Value));
  bytes->append(raw, sizeof(Value));
}

/// A name of letters, digits and underscores, as PLY wants it.
std::string PropertyName(const std::string& method) {
  std::string name = "label_" + method;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
}

std::string PlyHeader(Eigen::Index points, const std::vector<PointLabels>& methods, std::size_t shown, bool subset) {
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment diffsac_eval: colours are those of " +
                     PropertyName(methods[shown].method) +
                     "; labels: 0 an outlier, 1 an inlier, or the number of its structure\n";
  if (subset) text += "comment used: 1 for points that the estimators were given\n";
  text += "element vertex " + std::to_string(points) +
          "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nproperty uchar green\n"
          "property uchar blue\n";
  for (const PointLabels& method : methods) text += "property int " + PropertyName(method.method) + "\n";
  if (subset) text += "property uchar used\n";
  return text + "end_header\n";
}

/// An input and what each method made of it.
struct LabelledInput {
  std::string name;
  std::string path;
  PointMatrix points;
  std::vector<PointLabels> methods;
  std::size_t shown = 0;
  std::vector<std::int32_t> rows;
};

const EstimateRecord* RecordAt(const Cell& cell, std::uint64_t index) {
  const auto at = std::lower_bound(cell.records.begin(), cell.records.end(), index,
                                   [](const EstimateRecord& record, std::uint64_t i) { return record.index < i; });
  return at != cell.records.end() && at->index == index ? &*at : nullptr;
}

/// The inputs of one condition, read again.
class ConditionInputs {
 public:
  ConditionInputs(const ExperimentResults& results, std::size_t condition)
      : results_(results),
        condition_(condition),
        dataset_(MakeDataset(results.experiment.conditions[condition].data, results.experiment.seed)),
        sources_(dynamic_cast<const HasPointSources*>(dataset_.get())) {}

  std::size_t size() const {
    return sources_ == nullptr ? 0
                               : static_cast<std::size_t>(std::min<std::int64_t>(
                                     dataset_->size(), std::int64_t{results_.experiment.problems}));
  }

  /// Nothing for one that no method was run on, or that is another now.
  std::optional<LabelledInput> Read(std::size_t index) {
    const PointSource& source = sources_->SourceOf(index);
    const Example example = dataset_->Get(index);
    if (source.path != path_) sets_ = ReadPointFile(path_ = source.path);
    const auto set = std::find_if(sets_.begin(), sets_.end(), [&](const PointSet& one) {
      return one.name == source.name && one.points.rows() == source.total;
    });
    if (set == sets_.end()) return std::nullopt;
    LabelledInput input{example.id, source.path, set->points, {}, 0, source.rows};
    bool competes = false;
    for (const Cell& cell : results_.cells) {
      const EstimateRecord* record = cell.condition == condition_ ? RecordAt(cell, index) : nullptr;
      if (record == nullptr || record->points != example.problem.points.rows() || record->rows != source.rows) continue;
      const EstimatorRow& method = results_.experiment.methods[cell.method];
      if (!competes && method.Competes()) input.shown = input.methods.size();
      competes = competes || method.Competes();
      input.methods.push_back({method.name, LabelsOf(*record, set->points, example.problem.inlier_threshold)});
    }
    if (input.methods.empty()) return std::nullopt;
    return input;
  }

 private:
  const ExperimentResults& results_;
  std::size_t condition_;
  std::unique_ptr<Dataset> dataset_;
  const HasPointSources* sources_;
  std::string path_;  // Of the file that was read last, and its sets.
  std::vector<PointSet> sets_;
};

/// Names of files in one folder, each once, whatever the inputs are called.
class FileNames {
 public:
  std::string Of(const std::string& input, const std::string& extension) {
    std::string name = input;
    for (char& c : name)
      if (!std::isalnum(static_cast<unsigned char>(c)) && std::strchr("._-+=", c) == nullptr) c = '_';
    if (name.ends_with(extension)) name.resize(name.size() - extension.size());
    std::string unique = name + extension;
    for (int i = 2; !names_.insert(unique).second; ++i) unique = name + "_" + std::to_string(i) + extension;
    return unique;
  }

 private:
  std::set<std::string> names_;
};

void RemoveEarlier(const fs::path& folder) {
  std::error_code code;
  std::vector<std::string> files;
  for (fs::directory_iterator at(folder, code), end; !code && at != end; at.increment(code))
    if (at->path().extension() == ".csv" || at->path().extension() == ".ply") files.push_back(at->path().string());
  for (const std::string& file : files) RemoveFile(file);
  fs::remove(folder, code);  // Only where nothing else is in it.
}

/// A cloud stays a cloud; what came as text, and lines, which have no third coordinate, go out as text.
void WriteInput(const LabelledInput& input, const fs::path& folder, const std::string& prefix, FileNames* names) {
  MakeWritableFolder(folder.string());
  const bool text = IsTextPointFile(input.path) || input.points.cols() != 3;
  const std::string name = names->Of(prefix + input.name, text ? ".csv" : ".ply");
  WriteFileAtomically((folder / name).string(), text ? LabelsCsv(input.points, input.methods, input.rows)
                                                     : LabelsPly(input.points, input.methods, input.shown, input.rows));
}

}  // namespace

std::vector<std::int32_t> LabelsOf(const EstimateRecord& record, const PointMatrix& points, double threshold) {
  if (record.status != Status::kOk) return std::vector<std::int32_t>(static_cast<std::size_t>(points.rows()), 0);
  const std::vector<std::int32_t> own = ProblemLabels(record);
  if (record.rows.empty()) return own;
  const std::vector<ModelParameters> models = record.instances.empty() ? std::vector{record.model} : record.instances;
  const double limit = std::isfinite(record.inlier_threshold) ? record.inlier_threshold : threshold;
  std::vector<std::int32_t> labels;
  for (Eigen::Index i = 0; i < points.rows(); ++i) labels.push_back(NearestModel(models, points, i, limit));
  for (std::size_t i = 0; i < record.rows.size(); ++i) labels[static_cast<std::size_t>(record.rows[i])] = own[i];
  return labels;
}

std::string LabelsCsv(const PointMatrix& points, const std::vector<PointLabels>& methods,
                      const std::vector<std::int32_t>& rows) {
  std::string text = points.cols() == 3 ? "x,y,z" : "x,y";
  for (const PointLabels& method : methods) text += "," + CsvText(method.method);
  text += rows.empty() ? "\n" : ",used\n";
  const std::vector<std::uint8_t> used = UsedPoints(points.rows(), rows);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    for (Eigen::Index d = 0; d < points.cols(); ++d) text += (d == 0 ? "" : ",") + ShortestNumber(points(i, d));
    for (const PointLabels& method : methods) text += "," + std::to_string(method.labels[static_cast<std::size_t>(i)]);
    if (!rows.empty()) text += used[static_cast<std::size_t>(i)] != 0 ? ",1" : ",0";
    text += "\n";
  }
  return text;
}

std::string LabelsPly(const PointMatrix& points, const std::vector<PointLabels>& methods, std::size_t shown,
                      const std::vector<std::int32_t>& rows) {
  std::string bytes = PlyHeader(points.rows(), methods, shown, !rows.empty());
  const std::vector<std::int32_t>& colours = methods[shown].labels;
  const bool several = std::any_of(colours.begin(), colours.end(), [](std::int32_t label) { return label > 1; });
  const std::vector<std::uint8_t> used = UsedPoints(points.rows(), rows);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    for (Eigen::Index d = 0; d < 3; ++d) AppendBytes(points(i, d), &bytes);
    for (const std::uint8_t part : ColourParts(LabelColour(colours[at], several))) AppendBytes(part, &bytes);
    for (const PointLabels& method : methods) AppendBytes(method.labels[at], &bytes);
    if (!rows.empty()) AppendBytes(used[at], &bytes);
  }
  return bytes;
}

void WriteLabels(const ExperimentResults& results, const std::string& folder) {
  const ExperimentOptions& experiment = results.experiment;
  const fs::path labels = fs::path(folder) / kLabelsFolder;
  RemoveEarlier(labels);
  FileNames names;
  for (std::size_t c = 0; c < experiment.conditions.size(); ++c) {
    if (!experiment.estimates || experiment.labels == 0 || !IsPointSets(experiment.conditions[c].data)) continue;
    const std::string prefix = experiment.conditions.size() > 1 ? experiment.conditions[c].name + "_" : "";
    std::optional<ConditionInputs> inputs;
    std::size_t count = 0;
    try {
      inputs.emplace(results, c);
      count = std::min(inputs->size(), static_cast<std::size_t>(experiment.labels));
    } catch (const Error& error) {
      LogWarning("no labels of the points: " + std::string(error.what()));
      continue;
    }
    for (std::size_t i = 0; i < count; ++i)
      if (const auto input = inputs->Read(i)) WriteInput(*input, labels, prefix, &names);
    if (count < inputs->size())
      LogInfo("labels/ has the first " + std::to_string(count) + " of " + std::to_string(inputs->size()) +
              " inputs (labels: " + std::to_string(experiment.labels) + ")");
  }
}

}  // namespace diffsac
