// Images of known scenes, as `data_tools/convert.py colmap_points` writes them: SCENE/scene_points.h5, a group
// an image with
//   points   N × 5   X Y Z u v: the scene's unit, pixels without lens distortion
//   ratios   N       of the nearest to the second-nearest descriptor's distance, lower is better
//   K        3 × 3
//   pose     3 × 4   [R | t], world-to-camera; may be absent

#include <H5Cpp.h>

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/geometry/calibration.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/finite_points.h"
#include "lab/data/pair_filter.h"
#include "lab/data/pair_scenes.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/ground_truth/task_truth.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

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

constexpr const char* kFile = "scene_points.h5";

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

/// In memory: an image is a few hundred kilobytes.
class AbsolutePoses : public Dataset {
 public:
  explicit AbsolutePoses(const AbsolutePosesOptions& options) {
    const std::lock_guard lock(Hdf5Mutex());
    for (const SceneFolder& scene : FindScenes(options.paths, kFile)) AddScene(scene, options);
    if (examples_.empty()) throw Error(options.paths.front() + ": there is no image");
  }
  Task task() const override { return Task::kAbsolutePose; }
  std::int64_t size() const override { return static_cast<std::int64_t>(examples_.size()); }
  Example Get(std::uint64_t index) const override { return examples_.at(index); }

 private:
  void AddScene(const SceneFolder& scene, const AbsolutePosesOptions& options) {
    const std::string path = (std::filesystem::path(scene.folder) / kFile).string();
    WithClearErrors(path, [&] {
      const H5::H5File file = OpenHdf5(path);
      for (hsize_t i = 0; i < file.getNumObjs(); ++i) {
        const std::string name = file.getObjnameByIdx(i);
        const std::string place = path + ":/" + name;
        Example example = ReadImage(file.openGroup(name), options.inlier_threshold_px, place);
        example = Filtered(WithFinitePoints(std::move(example), place), options.filter);
        example.index = examples_.size();
        example.scene = scene.name;
        example.id = scene.name + "/" + name;
        examples_.push_back(std::move(example));
      }
    });
  }

  std::vector<Example> examples_;
};

const RegisteredDataset<AbsolutePosesOptions> kAbsolutePoses(
    "absolute_poses", DataSource::kFiles, "Images of known scenes (`data_tools/convert.py colmap_points`).",
    [](const AbsolutePosesOptions& options, std::uint64_t) { return std::make_unique<AbsolutePoses>(options); });

}  // namespace
}  // namespace diffsac
