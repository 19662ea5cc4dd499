#include <H5Cpp.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/geometry/calibration.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/sample_consensus.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/finite_points.h"
#include "lab/data/pair_filter.h"
#include "lab/data/pair_scenes.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/ground_truth/task_truth.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

/// A problem in each group of the HDF5 files of some scenes. In memory: one is a few hundred kilobytes.
class GroupedProblems : public Dataset {
 public:
  using Read = std::function<Example(const H5::Group&, const std::string& place)>;
  GroupedProblems(Task task, const std::vector<std::string>& paths, const std::string& file_name, const Read& read)
      : task_(task) {
    const std::lock_guard lock(Hdf5Mutex());
    for (const SceneFolder& scene : FindScenes(paths, file_name)) {
      const std::string path = (std::filesystem::path(scene.folder) / file_name).string();
      WithClearErrors(path, [&] { AddFile(scene.name, path, read); });
    }
    if (examples_.empty()) throw Error(paths.front() + ": there is no group in " + file_name);
  }
  Task task() const override { return task_; }
  std::int64_t size() const override { return static_cast<std::int64_t>(examples_.size()); }
  Example Get(std::uint64_t index) const override { return examples_.at(index); }

 private:
  void AddFile(const std::string& scene, const std::string& path, const Read& read) {
    const H5::H5File file = OpenHdf5(path);
    for (hsize_t i = 0; i < file.getNumObjs(); ++i) {
      const std::string name = file.getObjnameByIdx(i), place = path + ":/" + name;
      Example example = WithFinitePoints(read(file.openGroup(name), place), place);
      example.index = examples_.size();
      example.scene = scene;
      example.id = scene + "/" + name;
      examples_.push_back(std::move(example));
    }
  }

  Task task_;
  std::vector<Example> examples_;
};

// Images of known scenes, as `data_tools/convert.py colmap_points` writes them: SCENE/scene_points.h5, a group
// an image with
//   points   N × 5   X Y Z u v: the scene's unit, pixels without lens distortion
//   ratios   N       of the nearest to the second-nearest descriptor's distance, lower is better
//   K        3 × 3
//   pose     3 × 4   [R | t], world-to-camera; may be absent
struct AbsolutePosesOptions {
  std::vector<std::string> paths;
  double inlier_threshold_px = 4.0;
  PairFilter filter;

  void Bind(OptionsBinder& b) {
    b.Field("paths", paths).Help("scenes of `data_tools/convert.py colmap_points`, or folders of them");
    b.Field("inlier_threshold_px", inlier_threshold_px, Positive()).Help("ε, of the reprojection error, pixels");
    b.Field("max_ratio", filter.max_ratio, Limits{0.0, 1.0, true}).Help("only matches of at most this ratio");
    b.Require(!paths.empty(), "paths", "a list of folders");
  }
};

Example ReadImage(const H5::Group& group, double inlier_threshold_px, const std::string& place) {
  Example example;
  Problem& problem = example.problem;
  problem.task = Task::kAbsolutePose;
  problem.inlier_threshold = inlier_threshold_px;
  const Numbers points = ReadNumbersOfShape(group, "points", {0, 5}, place),
                ratios = ReadNumbersOfShape(group, "ratios", {0}, place);
  if (ratios.shape[0] != points.shape[0]) throw Error(place + "/ratios: expected one for each row of points");
  const auto count = static_cast<Eigen::Index>(points.shape[0]);
  problem.points = Eigen::Map<const PointMatrix>(points.values.data(), count, 5);
  problem.snn_ratio = Eigen::Map<const Eigen::VectorXd>(ratios.values.data(), count);
  const Numbers k = ReadNumbersOfShape(group, "K", {3, 3}, place);
  const Eigen::Matrix3d K =
      CheckedCalibration(Eigen::Matrix<double, 3, 3, Eigen::RowMajor>(k.values.data()), place + "/K");
  problem.cameras = CameraPair{K, K};
  if (!group.nameExists("pose")) return example;
  const Numbers pose = ReadNumbersOfShape(group, "pose", {3, 4}, place);
  example.truth.model = Eigen::Map<const Eigen::VectorXd>(pose.values.data(), 12);
  example.truth.inliers = AbsolutePoseInliers(problem, example.truth.model);
  return example;
}

const RegisteredDataset<AbsolutePosesOptions> kAbsolutePoses(
    "absolute_poses", DataSource::kFiles, "Images of known scenes (`data_tools/convert.py colmap_points`).",
    [](const AbsolutePosesOptions& options, std::uint64_t) {
      return std::make_unique<GroupedProblems>(
          Task::kAbsolutePose, options.paths, "scene_points.h5", [&](const H5::Group& group, const std::string& place) {
            return Filtered(ReadImage(group, options.inlier_threshold_px, place), options.filter);
          });
    });

// Matches of two clouds, as `convert.py registration` writes them: SCENE/cloud_matches.h5, a group a pair with
//   points   N × 6   x1 x2 x3 y1 y2 y3, in the clouds' unit
//   ratios   N       of the nearest to the second-nearest descriptor's distance, lower is better; may be absent
//   motion   3 × 4   [s R | t] from the first cloud to the second; may be absent
//   limits   3       ε, and the errors in degrees and in the unit that count alike: 5 and .6 where a
//                    motion is right within 5° and .6 m
struct CloudMatchesOptions {
  std::vector<std::string> paths;
  Task task = Task::kRigid;
  double inlier_threshold = 0.0;

  void Bind(OptionsBinder& b) {
    b.Field("paths", paths).Help("scenes of `convert.py registration`, or folders of them");
    b.Field("task", task, {Task::kRigid, Task::kSimilarity}).Help("what is estimated");
    b.Field("inlier_threshold", inlier_threshold, AtLeast(0.0)).Help("ε in the clouds' unit; 0: each file's own");
    b.Require(!paths.empty(), "paths", "a list of folders");
  }
};

Example ReadPair(const H5::Group& group, const CloudMatchesOptions& options, const std::string& place) {
  Example example;
  Problem& problem = example.problem;
  problem.task = options.task;
  const Numbers points = ReadNumbersOfShape(group, "points", {0, 6}, place),
                limits = ReadNumbersOfShape(group, "limits", {3}, place);
  for (const double limit : limits.values)
    if (!(limit > 0.0)) throw Error(place + "/limits: expected three numbers above 0");
  problem.inlier_threshold = options.inlier_threshold > 0.0 ? options.inlier_threshold : limits.values[0];
  const auto count = static_cast<Eigen::Index>(points.shape[0]);
  problem.points = Eigen::Map<const PointMatrix>(points.values.data(), count, 6);
  if (group.nameExists("ratios")) {
    const Numbers ratios = ReadNumbersOfShape(group, "ratios", {0}, place);
    if (ratios.shape[0] != points.shape[0]) throw Error(place + "/ratios: expected one for each row of points");
    problem.snn_ratio = Eigen::Map<const Eigen::VectorXd>(ratios.values.data(), count);
  }
  if (!group.nameExists("motion")) return example;
  const Numbers motion = ReadNumbersOfShape(group, "motion", {3, 4}, place);
  example.truth.model = Eigen::Map<const Eigen::VectorXd>(motion.values.data(), 12);
  example.truth.length_per_degree = limits.values[2] / limits.values[1];
  example.truth.inliers = InlierMask<Similarity>(problem.points, example.truth.model, problem.inlier_threshold);
  return example;
}

const RegisteredDataset<CloudMatchesOptions> kCloudMatches("cloud_matches", DataSource::kFiles,
                                                           "Matches of two clouds with the motion between them.",
                                                           [](const CloudMatchesOptions& options, std::uint64_t) {
                                                             return std::make_unique<GroupedProblems>(
                                                                 options.task, options.paths, "cloud_matches.h5",
                                                                 [&](const H5::Group& group, const std::string& place) {
                                                                   return ReadPair(group, options, place);
                                                                 });
                                                           });

}  // namespace
}  // namespace diffsac
