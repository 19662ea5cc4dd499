#include "lab/data/modelnet_planes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "diffsac/core/lru_cache.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/mesh_surface.h"
#include "lab/data/structure_sizes.h"
#include "lab/data/synthetic_points.h"

namespace diffsac {
namespace {

// Two planes are told apart when less than this share of either lies within so many ε of the other, measured on so many
// points; and clutter keeps so many ε from all.
constexpr double kSharedMost = 0.5;
constexpr double kThresholds = 2.0;
constexpr int kSharedSamples = 64;
// A clutter point is drawn so often until it is off the structures, then it is a uniform one.
constexpr int kClutterTries = 50;
// The mesh's unit sphere fills the box.
constexpr double kScale = 0.5 * kBoxSide;

using Points = std::vector<PlaneSection::Point>;

double DistanceOf(const Eigen::Vector3d& point, const MeshPlane& plane) {
  return std::abs(plane.normal.dot(point) + plane.offset);
}

double ShareWithin(const PlanarMesh& mesh, const MeshPlane& of, const MeshPlane& other, double distance, Rng rng) {
  int near = 0;
  for (int i = 0; i < kSharedSamples; ++i) near += DistanceOf(mesh.Sample(of, rng), other) <= distance;
  return static_cast<double>(near) / kSharedSamples;
}

Eigen::Quaterniond RandomTurn(Rng rng) {
  // Four normal values are a direction uniform on the sphere of unit quaternions.
  Eigen::Vector4d v;
  do {
    for (double& value : v) value = rng.Normal();
  } while (v.norm() < 1e-6);
  return Eigen::Quaterniond(v.normalized());
}

class ModelnetPlanes : public GeneratedDataset {
 public:
  ModelnetPlanes(const ModelnetPlanesOptions& options, std::uint64_t seed)
      : GeneratedDataset(options, "modelnet_planes/" + options.split, "modelnet_planes/" + options.split + "/", seed),
        options_(options),
        meshes_(FindMeshes("modelnet_planes", options.paths, options.subset)),
        cache_(options.cached_meshes) {}

  Task task() const override { return Task::kPlane; }

 private:
  Example Draw(std::uint64_t index, const Rng& rng) const override {
    for (std::size_t skipped = 0; skipped < meshes_.size(); ++skipped) {
      const std::string& path = meshes_[(index + skipped) % meshes_.size()];
      const std::shared_ptr<const PlanarMesh> mesh = cache_.Get(path);
      const std::vector<const MeshPlane*> planes = StructuresOf(*mesh, rng.Fork("shared"));
      if (planes.empty()) continue;
      Example example = Sampled(*mesh, planes, rng);
      example.id = "/" + std::filesystem::path(path).stem().string();
      return example;
    }
    throw Error("modelnet_planes: no mesh has faces on one plane with a share of " +
                std::to_string(options_.min_area_share) + " of its area (min_area_share)");
  }

  double Near() const { return kThresholds * options_.inlier_threshold / kScale; }

  // The large planes, each told apart from those before it.
  std::vector<const MeshPlane*> StructuresOf(const PlanarMesh& mesh, const Rng& rng) const {
    std::vector<const MeshPlane*> found;
    for (const MeshPlane& plane : mesh.planes()) {
      if (mesh.ShareOf(plane) < options_.min_area_share) break;
      const bool is_own = std::none_of(found.begin(), found.end(), [&](const MeshPlane* other) {
        return ShareWithin(mesh, plane, *other, Near(), rng) >= kSharedMost ||
               ShareWithin(mesh, *other, plane, Near(), rng) >= kSharedMost;
      });
      if (is_own) found.push_back(&plane);
      if (static_cast<int>(found.size()) == options_.max_structures) break;
    }
    return found;
  }

  // Numbers of points of the planes and of all.
  std::vector<int> DrawSizes(const std::vector<const MeshPlane*>& planes, Rng rng, int* total) const {
    *total = DrawWhole(options_.num_points, rng);
    const double ratio = rng.Uniform(options_.outlier_ratio.low, options_.outlier_ratio.high);
    const int fewest = FewestOfStructure(task()), least = fewest * static_cast<int>(planes.size());
    std::vector<double> areas;
    for (const MeshPlane* plane : planes) areas.push_back(plane->area());
    return ShareOut(areas, std::clamp(static_cast<int>(std::lround(*total * (1.0 - ratio))), least, *total), fewest);
  }

  Example Sampled(const PlanarMesh& mesh, const std::vector<const MeshPlane*>& planes, const Rng& rng) const {
    const Eigen::Matrix3d turn = RandomTurn(rng.Fork("turn")).toRotationMatrix();
    const auto place = [&](const Eigen::Vector3d& point) -> PlaneSection::Point {
      const Eigen::Vector3d moved = kScale * (turn * point + Eigen::Vector3d::Ones());
      return {moved[0], moved[1], moved[2]};
    };
    int total = 0;
    const std::vector<int> sizes = DrawSizes(planes, rng.Fork("counts"), &total);
    Example example;
    Points points;
    std::vector<std::int32_t> labels;
    NoiseSource noise(NoiseKind::kGaussian, options_.noise_scale, options_.inlier_threshold, rng.Fork("noise"));
    for (std::size_t k = 0; k < planes.size(); ++k) {
      Rng own = rng.Fork("inliers", k);
      const Eigen::Vector3d normal = planes[k]->normal;
      for (int i = 0; i < sizes[k]; ++i)
        points.push_back(place(mesh.Sample(*planes[k], own) + noise.Next() / kScale * normal));
      labels.resize(points.size(), static_cast<std::int32_t>(k + 1));
      ModelParameters model(4);
      model.head<3>() = turn * normal;
      model[3] = kScale * (planes[k]->offset - model.head<3>().sum());
      example.truth.structures.push_back(model);
    }
    const int outliers = total - static_cast<int>(points.size());
    Rng clutter = rng.Fork("clutter");
    Eigen::Vector3d point;
    for (int i = 0; i < std::lround(options_.clutter_share * outliers); ++i)
      if (DrawClutter(mesh, planes, clutter, &point)) points.push_back(place(point));
    AppendUniform(total - static_cast<int>(points.size()), rng.Fork("uniform"), &points);
    labels.resize(points.size(), 0);
    example.problem.task = task();
    example.problem.inlier_threshold = options_.inlier_threshold;
    SetShuffled(points, labels, rng.Fork("shuffle"), &example);
    ArrangeStructures(1, &example.truth);
    return example;
  }

  // Of the mesh, off its structures; false where that is hardly to be found.
  bool DrawClutter(const PlanarMesh& mesh, const std::vector<const MeshPlane*>& planes, Rng& rng,
                   Eigen::Vector3d* point) const {
    for (int i = 0; i < kClutterTries; ++i) {
      int triangle = 0;
      *point = mesh.surface().Sample(rng, &triangle);
      if (std::none_of(planes.begin(), planes.end(),
                       [&](const MeshPlane* plane) { return DistanceOf(*point, *plane) <= Near(); }))
        return true;
    }
    return false;
  }

  ModelnetPlanesOptions options_;
  std::vector<std::string> meshes_;
  mutable LruCache<PlanarMesh> cache_;
};

}  // namespace

void ModelnetPlanesOptions::Bind(OptionsBinder& b) {
  b.Field("paths", paths).Help("OFF files, or folders that hold them at any depth");
  b.Field("subset", subset).Help("only files in a folder of this name (train, test); empty: all");
  b.Field("num_points", num_points, Within(5, 1e7)).Help("points of a problem");
  b.Field("outlier_ratio", outlier_ratio, Within(0.0, 1.0)).Help("share of points on no structure");
  b.Field("clutter_share", clutter_share, Within(0.0, 1.0))
      .Help("share of the outliers that lie on the rest of the mesh; the others are uniform");
  b.Field("inlier_threshold", inlier_threshold, Limits{0.0, 0.05 * kBoxSide, true})
      .Help("ε; the mesh's sphere has a diameter of 10");
  b.Field("noise_scale", noise_scale, AtLeast(0.0)).Help("σ of the inliers' distances (gaussian); 0: ε/3");
  b.Field("min_area_share", min_area_share, Within(PlanarMesh::kLeastShare, 1.0))
      .Help("share of the mesh's area that makes faces on one plane a structure");
  b.Field("max_structures", max_structures, Within(1, 20)).Help("at most so many, the largest");
  b.Field("cached_meshes", cached_meshes, AtLeast(1)).Help("meshes kept in memory");
  BindStream(b, "its name, of the random numbers; it does not choose meshes");
  b.Require(IsWhole(num_points), "num_points", "whole numbers");
  b.Require(!paths.empty(), "paths", "a list of OFF files or folders");
}

std::unique_ptr<Dataset> MakeModelnetPlanes(const ModelnetPlanesOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  StructureOptions most;
  most.structures = options.max_structures;
  CheckStructures(most, Task::kPlane, options.num_points.low);
  return std::make_unique<ModelnetPlanes>(options, seed);
}

namespace {

const RegisteredDataset<ModelnetPlanesOptions> kModelnetPlanes(
    "modelnet_planes", DataSource::kGenerated, "The flat parts of a mesh (ModelNet40's OFF files), several at once.",
    MakeModelnetPlanes);

}  // namespace

}  // namespace diffsac
