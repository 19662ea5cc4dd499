#include "lab/data/modelnet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>

#include "diffsac/core/lru_cache.h"
#include "diffsac/core/status.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/depth_buffer.h"
#include "lab/data/off_mesh.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// All of the mesh, which is within distance 1, stays before the camera.
constexpr double kLeastDistance = 1.2;
constexpr double kLeastDepth = 1e-6;
// Views are drawn again when fewer than one point in so many is seen by both.
constexpr int kDrawsPerPoint = 60;
constexpr int kViewTries = 20;

// OFF files in the order of the paths: files as they stand, and those below folders in the order of their names, only
// from folders named `subset` unless that is empty.
std::vector<std::string> FindMeshes(const std::vector<std::string>& paths, const std::string& subset) {
  std::vector<std::string> found;
  for (const std::string& path : paths) {
    std::error_code code;
    if (fs::is_regular_file(path, code)) {
      found.push_back(path);
      continue;
    }
    if (!fs::is_directory(path, code)) throw Error(path + ": no such file or folder");
    const auto first = static_cast<std::ptrdiff_t>(found.size());
    for (const auto& entry : fs::recursive_directory_iterator(path)) {
      const std::string extension = entry.path().extension().string();
      if (entry.is_regular_file() && (extension == ".off" || extension == ".OFF") &&
          (subset.empty() || entry.path().parent_path().filename() == subset))
        found.push_back(entry.path().string());
    }
    std::sort(found.begin() + first, found.end());
  }
  if (found.empty())
    throw Error("modelnet40: no OFF files in the given paths" + (subset.empty() ? "" : " (subset " + subset + ")"));
  return found;
}

// World-to-camera, from `position` towards `target`, turned about the axis by `roll_deg`.
RigidMotion LookAt(const Eigen::Vector3d& position, const Eigen::Vector3d& target, double roll_deg) {
  const Eigen::Vector3d axis = (target - position).normalized();
  // The world's y axis points down in the image unless the camera looks along it.
  const Eigen::Vector3d down = std::abs(axis[1]) < 0.99 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d right = down.cross(axis).normalized();
  RigidMotion pose;
  pose.rotation << right.transpose(), axis.cross(right).transpose(), axis.transpose();
  pose.rotation = Eigen::AngleAxisd(roll_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ()) * pose.rotation;
  pose.translation = -(pose.rotation * position);
  return pose;
}

// Two cameras around a mesh.
struct Views {
  VirtualPair pair;
  RigidMotion pose1, pose2;  // world-to-camera
};

class Modelnet : public GeneratedDataset {
 public:
  Modelnet(const ModelnetOptions& options, std::uint64_t seed)
      : GeneratedDataset(options, "modelnet40_" + ToString(options.task) + "/" + options.split,
                         "modelnet40_" + ToString(options.task) + "/" + options.split + "/", seed),
        options_(options),
        task_(options.task),
        meshes_(FindMeshes(options.paths, options.subset)),
        cache_(options.cached_meshes) {}

  Task task() const override { return task_; }

 private:
  Example Draw(std::uint64_t index, const Rng& rng) const override {
    const std::string& path = meshes_[index % meshes_.size()];
    const std::shared_ptr<const MeshSurface> surface = cache_.Get(path);
    const PointCounts counts = options_.matches.DrawCounts(task_, rng.Fork("counts"));
    const int outliers = counts.total - counts.inliers;
    const int displaced = DrawDisplacedCount(options_.matches, outliers, rng.Fork("displaced_count"));
    for (int i = 0; i < kViewTries; ++i) {
      const Views views = DrawViews(rng.Fork("views", i));
      std::vector<Eigen::Vector4d> seen =
          SeenByBoth(*surface, views, counts.inliers + displaced, rng.Fork("points", i));
      if (static_cast<int>(seen.size()) < counts.inliers + displaced) continue;
      ExactMatches exact;
      exact.displaced.assign(seen.begin() + counts.inliers, seen.end());
      seen.resize(counts.inliers);
      exact.inliers = std::move(seen);
      Example example = MakeMatches(options_.matches, task_, views.pair, exact, counts.total, rng.Fork("matches"));
      SetTruth(views.pair, Eigen::Matrix3d::Zero(), &example);
      example.id = "/" + fs::path(path).stem().string();
      return example;
    }
    throw Error(path + ": in " + std::to_string(kViewTries) +
                " pairs of views too few points of this mesh are seen by both");
  }

  RigidMotion DrawPose(const Eigen::Vector3d& direction, double distance, Rng& rng) const {
    const Eigen::Vector3d target = options_.aim_offset * rng.Uniform() * RandomDirection(rng);
    const double roll = options_.roll_deg * rng.Uniform(-1.0, 1.0);
    return LookAt(distance * direction, target, roll);
  }

  double Distance(const VirtualCamera& camera, Rng& rng) const {
    const double radius_px =
        rng.Uniform(options_.fill.low, options_.fill.high) * 0.5 * std::min(camera.size.width, camera.size.height);
    return std::max(kLeastDistance, camera.K(0, 0) / radius_px);
  }

  Views DrawViews(Rng rng) const {
    Views views;
    views.pair.first = RandomCamera(options_.cameras, rng.Fork("camera"));
    views.pair.second = RandomSecondCamera(options_.cameras, views.pair.first, rng.Fork("second_camera"));
    const Eigen::Vector3d direction = RandomDirection(rng);
    const double angle = rng.Uniform(options_.view_angle_deg.low, options_.view_angle_deg.high);
    views.pose1 = DrawPose(direction, Distance(views.pair.first, rng), rng);
    const Eigen::Vector3d other = Tilted(direction, angle, rng);
    views.pose2 = DrawPose(other, Distance(views.pair.second, rng), rng);
    views.pair.motion = RelativeMotion(views.pose1, views.pose2);
    return views;
  }

  // Up to `count` points that both cameras see.
  std::vector<Eigen::Vector4d> SeenByBoth(const MeshSurface& surface, const Views& views, int count, Rng rng) const {
    const DepthBuffer first(surface.mesh(), views.pair.first, views.pose1);
    const DepthBuffer second(surface.mesh(), views.pair.second, views.pose2);
    std::vector<Eigen::Vector4d> seen;
    Eigen::Vector4d match;
    for (int draw = 0; draw < kDrawsPerPoint * count && static_cast<int>(seen.size()) < count; ++draw) {
      int triangle = 0;
      const Eigen::Vector3d point = surface.Sample(rng, &triangle);
      if (!first.Sees(point, triangle, options_.depth_tolerance) ||
          !second.Sees(point, triangle, options_.depth_tolerance))
        continue;
      const Eigen::Vector3d local = views.pose1.rotation * point + views.pose1.translation;
      if (ProjectIntoBoth(views.pair, local, kLeastDepth, &match)) seen.push_back(match);
    }
    return seen;
  }

  ModelnetOptions options_;
  Task task_;
  std::vector<std::string> meshes_;
  mutable LruCache<MeshSurface> cache_;
};

}  // namespace

ModelnetOptions::ModelnetOptions() {
  matches.num_points = 200;
  matches.outlier_ratio = Range(0.1, 0.6);
  matches.inlier_threshold_px = 4.0;
  matches.noise_px = 0.25;
  matches.displaced_share = 0.0;
  matches.snn_ratio = false;
  cameras.image_width = 640;
  cameras.image_aspect = 0.75;
  cameras.focal = Range(0.9, 1.5);
  cameras.principal_offset = 0.0;
  cameras.same_camera = 1.0;
}

void ModelnetOptions::Bind(OptionsBinder& b) {
  b.Field("paths", paths).Help("OFF files, or folders that hold them at any depth");
  b.Field("subset", subset).Help("only files in a folder of this name (train, test); empty: all");
  b.Field("task", task, {Task::kFundamental, Task::kEssential}).Help("what is estimated");
  matches.Bind(b);
  BindStream(b, "its name, of the random numbers; it does not choose meshes");
  b.Require(!paths.empty(), "paths", "a list of OFF files or folders");
}

std::unique_ptr<Dataset> MakeModelnet(const ModelnetOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  CheckCounts(options.matches.num_points, options.task);
  return std::make_unique<Modelnet>(options, seed);
}

const RegisteredDataset<ModelnetOptions> kModelnet("modelnet40", DataSource::kGenerated,
                                                   "Two virtual views of a mesh (ModelNet40's OFF files).",
                                                   MakeModelnet);

}  // namespace diffsac
