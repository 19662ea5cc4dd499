#include "lab/registration/scan.h"

#include <open3d/geometry/BoundingVolume.h>
#include <open3d/geometry/KDTreeFlann.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/io/PointCloudIO.h>
#include <open3d/pipelines/registration/Feature.h>
#include <open3d/utility/Logging.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <tuple>

#include "diffsac/core/status.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using open3d::geometry::KDTreeSearchParamHybrid;
using open3d::geometry::PointCloud;

constexpr double kMostPoints = 10000;
constexpr const char* kFormats = "PLY, PCD, XYZ, XYZN, XYZRGB or PTS";

bool IsCloudName(const fs::path& path) {
  static const std::set<std::string> kEndings = {".ply", ".pcd", ".xyz", ".xyzn", ".xyzrgb", ".pts"};
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return kEndings.count(ending) > 0;
}

std::size_t Read(const std::string& path, PointCloud* cloud) {
  std::error_code code;
  if (!fs::is_regular_file(path, code)) throw Error(path + ": no such file");
  CheckCloudName(path);
  // What is wrong is said once, by this program.
  open3d::utility::SetVerbosityLevel(open3d::utility::VerbosityLevel::Error);
  bool read = false;
  try {
    read = open3d::io::ReadPointCloud(path, *cloud);
  } catch (const std::exception&) {
  }
  if (!read || cloud->IsEmpty()) throw Error(path + ": no points that can be read; expected " + kFormats);
  const std::size_t points = cloud->points_.size();
  cloud->RemoveNonFinitePoints();
  if (cloud->IsEmpty()) throw Error(path + ": no point has finite coordinates");
  if (!std::isfinite(cloud->GetAxisAlignedBoundingBox().GetExtent().squaredNorm()))
    throw Error(path + ": coordinates beyond all measure");
  return points - cloud->points_.size();
}

/// Of up to 1000 points.
double Resolution(const PointCloud& cloud) {
  const open3d::geometry::KDTreeFlann tree(cloud);
  const std::size_t step = std::max<std::size_t>(1, cloud.points_.size() / 1000);
  std::vector<double> distances, two;
  std::vector<int> nearest;
  for (std::size_t i = 0; i < cloud.points_.size(); i += step)
    if (tree.SearchKNN(cloud.points_[i], 2, nearest, two) == 2) distances.push_back(std::sqrt(two[1]));
  if (distances.empty()) return 0.0;
  std::nth_element(distances.begin(), distances.begin() + distances.size() / 2, distances.end());
  return distances[distances.size() / 2];
}

bool IsNearOrigin(const PointCloud& cloud) {
  const auto box = cloud.GetAxisAlignedBoundingBox();
  const Eigen::Vector3d half = 0.5 * box.GetExtent();
  return (box.GetCenter().cwiseAbs() - half).maxCoeff() <= half.norm();
}

/// 0 where all points are at one place.
double SuitableVoxel(const PointCloud& read) {
  PointCloud cloud = read;
  cloud.RemoveDuplicatedPoints();
  // Voxels are counted by integers.
  double voxel = std::max(2.0 * Resolution(cloud), 1e-6 * cloud.GetAxisAlignedBoundingBox().GetExtent().maxCoeff());
  if (!(voxel > 0.0)) return 0.0;
  for (double left = 0.0;; voxel *= std::max(1.05, std::sqrt(left / kMostPoints))) {
    left = static_cast<double>(cloud.VoxelDownSample(voxel)->points_.size());
    if (left <= kMostPoints) return voxel;
  }
}

/// As RootSIFT: Hellinger's distance of histograms is the Euclidean one of their roots, whose length is 1.
DescriptorMatrix Descriptors(const PointCloud& cloud, double voxel) {
  const auto features =
      open3d::pipelines::registration::ComputeFPFHFeature(cloud, KDTreeSearchParamHybrid(5.0 * voxel, 100));
  DescriptorMatrix rows = features->data_.transpose().cast<float>();
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    if (const float sum = rows.row(i).sum(); sum > 0.0f) rows.row(i) = (rows.row(i) / sum).cwiseMax(0.0f).cwiseSqrt();
  return rows;
}

}  // namespace

std::string Scan::name() const { return fs::path(path).filename().string(); }

Eigen::Matrix4d TransformOf(const RigidMotion& motion) {
  Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
  transform.topLeftCorner<3, 3>() = motion.rotation;
  transform.topRightCorner<3, 1>() = motion.translation;
  return transform;
}

std::vector<std::string> ScansOfFolder(const std::string& folder) {
  std::error_code code;
  std::vector<std::string> scans;
  for (const auto& entry : fs::directory_iterator(folder, code))
    if (entry.is_regular_file() && IsCloudName(entry.path())) scans.push_back(entry.path().string());
  if (code) throw Error(folder + ": no such folder");
  std::sort(scans.begin(), scans.end());
  return scans;
}

void CheckCloudName(const std::string& path) {
  if (!IsCloudName(path)) throw Error(path + ": expected a name that ends as one of " + kFormats);
}

ScanPlan PlanScans(const std::vector<std::string>& paths) {
  constexpr std::size_t kMostKept = 10'000'000;
  ScanPlan plan;
  std::size_t kept = 0;
  for (const std::string& path : paths) {
    const auto cloud = std::make_shared<PointCloud>();
    const std::size_t left_out = Read(path, cloud.get());
    plan.voxel = std::max(plan.voxel, SuitableVoxel(*cloud));
    plan.has_scanner = plan.has_scanner && IsNearOrigin(*cloud);
    kept += cloud->points_.size();
    if (kept <= kMostKept) plan.read[path] = {cloud, left_out};
  }
  return plan;
}

Scan ReadScan(const std::string& path, const ScanPlan& plan) {
  const double voxel = plan.voxel;
  PointCloud read;
  Scan scan;
  scan.path = path;
  if (const auto found = plan.read.find(path); found != plan.read.end())
    std::tie(read, scan.left_out) = std::tie(*found->second.first, found->second.second);
  else
    scan.left_out = Read(path, &read);
  scan.points = read.points_.size();
  if (voxel > 0.0 && read.GetAxisAlignedBoundingBox().GetExtent().maxCoeff() / voxel > 1e9)
    throw Error(path + ": a voxel of " + std::to_string(voxel) + " is too small for its extent");
  // Open3D's normals lose their digits far from the origin.
  scan.middle = read.GetCenter();
  read.Translate(-scan.middle);
  const auto cloud = voxel > 0.0 ? read.VoxelDownSample(voxel) : std::make_shared<PointCloud>();
  if (!cloud->HasNormals() && !cloud->IsEmpty()) {
    cloud->EstimateNormals(KDTreeSearchParamHybrid(2.0 * voxel, 30));
    cloud->OrientNormalsTowardsCameraLocation(plan.has_scanner ? (-scan.middle).eval() : cloud->GetCenter());
  }
  if (!cloud->IsEmpty()) scan.descriptors = Descriptors(*cloud, voxel);
  scan.cloud = cloud;
  return scan;
}

void WriteMoved(const std::string& input, const RigidMotion& motion, const std::string& output) {
  PointCloud cloud;
  Read(input, &cloud);
  cloud.Transform(TransformOf(motion));
  WriteFileAtomically(output, [&](const std::string& temporary) {
    if (!open3d::io::WritePointCloud(temporary, cloud)) throw Error(output + ": cannot be written");
  });
}

}  // namespace diffsac
