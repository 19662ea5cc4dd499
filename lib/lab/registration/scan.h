#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/geometry/rigid_motion.h"
#include "diffsac/problem/image_pair.h"

namespace open3d::geometry {
class PointCloud;
}

namespace diffsac {

/// A cloud that is thinned out to one point a voxel and described.
struct Scan {
  std::string path;
  std::string name() const;                          ///< The file's.
  std::size_t points = 0;                            ///< Of the file, those with finite coordinates.
  std::size_t left_out = 0;                          ///< Those without.
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< The mean point, in the file's frame.
  /// With normals, about `middle`: clouds far from the origin would lose digits.
  std::shared_ptr<const open3d::geometry::PointCloud> cloud;
  DescriptorMatrix descriptors;  ///< A row a point of `cloud`, of unit length.
};

/// The files with the endings of clouds in a folder (PLY, PCD, XYZ, PTS), by name. Throws Error where there is no such
/// folder.
std::vector<std::string> ScansOfFolder(const std::string& folder);

/// How scans that are compared are described: all alike.
struct ScanPlan {
  double voxel = 0.0;  ///< A cube's side. 0: nothing is described.
  /// Normals that a file lacks look at its frame's origin, where the scanner was; else at the cloud's middle.
  bool has_scanner = true;
  /// The clouds of some files as they were read, and how many points without finite coordinates each has besides.
  std::map<std::string, std::pair<std::shared_ptr<const open3d::geometry::PointCloud>, std::size_t>> read = {};
};

/// A voxel that suits all of these files: twice the resolution of each (the median distance of a point to the nearest
/// other one), or more, such that at most 10 000 points of it are left; 0 where each has fewer than two places. There
/// is a scanner where no cloud lies far from its origin. Clouds are kept while they are ten million points together.
/// Throws Error where a file is no cloud or has no points.
ScanPlan PlanScans(const std::vector<std::string>& paths);

/// Reads, thins out and describes: roots of FPFH (Rusu, Blodow and Beetz, "Fast point feature histograms for 3D
/// registration", ICRA 2009) of 5 voxels, with the file's normals or those of 2 voxels. Throws Error as PlanScans.
Scan ReadScan(const std::string& path, const ScanPlan& plan);

/// Throws Error where a name does not end as a cloud's.
void CheckCloudName(const std::string& path);

/// Writes the cloud of a file, moved, in the format of the name's ending. Throws Error.
void WriteMoved(const std::string& input, const RigidMotion& motion, const std::string& output);

/// [R | t] with the row 0 0 0 1, as Open3D takes motions.
Eigen::Matrix4d TransformOf(const RigidMotion& motion);

}  // namespace diffsac
