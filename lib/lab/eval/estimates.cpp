#include "lab/eval/estimates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <utility>

#include "diffsac/estimate/diagnose.h"
#include "lab/config/run_directory.h"
#include "lab/eval/hdf5_columns.h"
#include "lab/eval/kept_examples.h"
#include "lab/eval/results.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

constexpr const char* kFormat = "diffsac estimates 1";

// A link's name cannot hold a slash; one name is that of the examples.
std::string LinkName(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  return name.empty() || name == "." || name == ".." || name == kExamplesGroup ? "_" + name : name;
}

std::vector<double> PoseMatrix(const std::optional<RigidMotion>& pose) {
  using Pose = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
  return pose ? NumbersOf((Pose() << pose->rotation, pose->translation).finished()) : std::vector<double>();
}

/// Of unknown focal lengths, with their intervals.
void PutFocals(const Columns<EstimateRecord>& columns) {
  using R = EstimateRecord;
  if (!columns.Any([](const R& r) { return r.focal.has_value(); })) return;
  columns.Rows("focal", 6, [](const R& r) {
    std::vector<double> row;
    for (int i = 0; r.focal && i < 2; ++i)
      row.insert(row.end(), {r.focal->focal_px[i], r.focal->low_px[i], r.focal->high_px[i]});
    return row;
  });
  columns.Values("focal_observable", [](const R& r) -> std::int32_t {
    if (!r.focal) return 0;
    const auto& [first, second] = r.focal->observable;
    return first && second ? 1 : first ? 2 : second ? 3 : 0;
  });
}

/// `width`: values of a model.
void PutInstances(const Columns<EstimateRecord>& columns, std::size_t width) {
  using R = EstimateRecord;
  if (!columns.Any([](const R& r) { return !r.instances.empty(); })) return;
  columns.Lists(
      "structures",
      [](const R& r) {
        std::vector<double> values;
        for (const ModelParameters& model : r.instances) values.insert(values.end(), model.begin(), model.end());
        return values;
      },
      width);
  columns.Lists("labels", [](const R& r) { return r.assignment; });
  // One for each structure, of which some may have none: NaN.
  const auto knows = [](const R& r) { return !r.instances.empty() && r.instance_values.size() == r.instances.size(); };
  if (columns.Any(knows))
    columns.Flat("structure_values", [&](const R& r) {
      return knows(r) ? r.instance_values : std::vector<double>(r.instances.size(), std::nan(""));
    });
}

/// All columns, in the order of the file (docs/estimates.md).
void PutColumns(const Columns<EstimateRecord>& columns) {
  using R = EstimateRecord;
  columns.Values("index", [](const R& r) { return r.index; });
  columns.Values("id", [](const R& r) { return r.id; });
  columns.Values("scene", [](const R& r) { return r.scene; });
  columns.Values("status", [](const R& r) { return std::string(ToString(r.status)); });
  const std::size_t width = columns.Rows("model", 1, [](const R& r) { return NumbersOf(r.model); });
  columns.Rows("pose", 12, [](const R& r) { return PoseMatrix(r.pose); });
  columns.Values("degeneracy", [](const R& r) { return std::string(ToString(r.degeneracy)); });
  if (columns.Any([](const R& r) { return r.ambiguous_pose.has_value(); }))
    columns.Rows("ambiguous_pose", 12, [](const R& r) { return PoseMatrix(r.ambiguous_pose); });
  columns.Values("cheirality_failure_ratio", [](const R& r) { return r.cheirality_failure_ratio; });
  if (columns.Any([](const R& r) { return r.pose_covariance.has_value(); }))
    columns.Rows("pose_covariance", 1,
                 [](const R& r) { return r.pose_covariance ? NumbersOf(*r.pose_covariance) : std::vector<double>(); });
  PutFocals(columns);
  columns.Values("score", [](const R& r) { return r.score; });
  columns.Values("sigma", [](const R& r) { return r.sigma; });
  columns.Values("log10_nfa", [](const R& r) { return r.log10_nfa; });
  columns.Values("draws", [](const R& r) { return r.draws; });
  columns.Values("points", [](const R& r) { return std::int64_t{r.points}; });
  columns.Lists("inliers", [](const R& r) { return r.inlier_rows; });
  columns.Values("inlier_threshold", [](const R& r) { return r.inlier_threshold; });
  if (columns.Any([](const R& r) { return !r.rows.empty(); })) columns.Lists("rows", [](const R& r) { return r.rows; });
  columns.Lists("probabilities", [](const R& r) { return r.inlier_probabilities; });
  PutInstances(columns, width);
}

void PutCell(const ExperimentResults& results, const Cell& cell, H5::H5File& file) {
  const std::string &method = results.experiment.methods[cell.method].name,
                    &condition = results.experiment.conditions[cell.condition].name;
  std::set<std::uint64_t> kept;
  for (const KeptExample& one : results.examples)
    if (one.condition == cell.condition) kept.insert(one.example.index);
  std::vector<const EstimateRecord*> records;
  for (const ProblemRecord& record : cell.records)
    if (results.experiment.estimates || kept.contains(record.index)) records.push_back(&record);
  const std::string folder = LinkName(method);
  if (!file.nameExists(folder)) file.createGroup(folder);
  const H5::Group group = file.createGroup(folder + "/" + LinkName(condition));
  PutText(group, "method", method);
  PutText(group, "condition", condition);
  PutColumns({group, std::move(records)});
}

}  // namespace

EstimateRecord RecordOf(const Example& example, const Estimate& estimate, bool whole) {
  EstimateRecord record;
  record.index = example.index;
  record.id = ProblemName(example);
  record.scene = example.scene;
  record.status = estimate.status;
  record.points = static_cast<int>(example.problem.points.rows());
  record.draws = estimate.stats.iterations;
  if (record.points > 0) record.largest_coordinate = example.problem.points.cwiseAbs().maxCoeff();
  record.log10_nfa = estimate.log10_nfa;
  if (estimate.status != Status::kOk) return record;
  record.degeneracy = estimate.degeneracy;
  if (!whole) return record;
  record.model = estimate.model;
  record.pose = PoseOfEstimate(estimate, example.problem);
  for (std::size_t i = 0; i < estimate.inliers.size(); ++i)
    if (estimate.inliers[i] != 0) record.inlier_rows.push_back(static_cast<std::int32_t>(i));
  record.inlier_threshold = estimate.inlier_threshold;
  if (record.pose) record.pose_covariance = estimate.pose_covariance;
  record.ambiguous_pose = estimate.ambiguous_pose;
  record.cheirality_failure_ratio = estimate.cheirality_failure_ratio;
  record.focal = estimate.focal;
  record.score = estimate.score;
  record.sigma = estimate.sigma;
  record.inlier_probabilities = estimate.inlier_probabilities;
  record.instances = estimate.instances;
  record.assignment = estimate.assignment;
  record.instance_values = estimate.instance_values;
  return record;
}

std::array<double, 7> PoseNumbers(const std::optional<RigidMotion>& pose) {
  std::array<double, 7> numbers;
  numbers.fill(std::nan(""));
  if (!pose) return numbers;
  Eigen::Quaterniond q(pose->rotation);
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  numbers = {q.w(), q.x(), q.y(), q.z(), std::nan(""), std::nan(""), std::nan("")};
  if (!pose->translation.isZero(0.0)) std::copy_n(pose->translation.data(), 3, numbers.begin() + 4);
  return numbers;
}

void WriteEstimates(const ExperimentResults& results, const std::string& folder) {
  const ExperimentOptions& experiment = results.experiment;
  const std::string path = (std::filesystem::path(folder) / kEstimatesFile).string();
  if (!experiment.estimates && results.examples.empty()) return RemoveFile(path);
  WriteHdf5(path, [&](Hdf5Output& output) {
    output.Use([&](H5::H5File& file) {
      const H5::Group root = file.openGroup("/");
      PutText(root, "format", kFormat);
      PutText(root, "experiment", experiment.name);
      PutText(root, "task", ToString(experiment.task));
      PutText(root, "git_revision", GitRevision());
      for (const Cell& cell : results.cells) PutCell(results, cell, file);
      PutExamples(results, file);
    });
  });
}

}  // namespace diffsac
