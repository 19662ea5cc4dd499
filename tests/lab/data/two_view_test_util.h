#pragma once

#include <Eigen/Geometry>
#include <cstdio>
#include <string>

#include "diffsac/core/random.h"
#include "lab/files/correspondence_files.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {

inline Eigen::Vector3d RandomVector(Rng* rng) { return {rng->Normal(), rng->Normal(), rng->Normal()}; }

inline RigidMotion RandomCamera(Rng* rng) {
  RigidMotion camera;
  camera.rotation = Eigen::AngleAxisd(0.1 * rng->Normal(), RandomVector(rng).normalized()).toRotationMatrix();
  camera.translation = 0.3 * RandomVector(rng);
  return camera;
}

inline Eigen::Matrix3d Calibration(double fx, double fy, double cx, double cy) {
  Eigen::Matrix3d K;
  K << fx, 0, cx, 0, fy, cy, 0, 0, 1;
  return K;
}

inline Eigen::Vector2d Project(const Eigen::Matrix3d& K, const RigidMotion& camera, const Eigen::Vector3d& point) {
  return (K * (camera.rotation * point + camera.translation)).hnormalized();
}

// Pairs of neighbouring images that see random points exactly; every third correspondence is an outlier.
inline CorrespondenceSet SyntheticSet(int num_pairs, int num_points, Rng rng) {
  CorrespondenceSet set;
  std::vector<std::string> names;
  for (int i = 0; i <= num_pairs; ++i) {
    char name[16];
    std::snprintf(name, sizeof(name), "im_%03d", i);
    names.push_back(name);
    set.cameras[name] = RandomCamera(&rng);
  }
  for (int i = 0; i < num_pairs; ++i) {
    Example pair;
    pair.image1 = names[i];
    pair.image2 = names[i + 1];
    pair.id = pair.image1 + "-" + pair.image2;
    Problem& problem = pair.problem;
    problem.cameras = CameraPair{Calibration(500.5, 501.25, 320, 240), Calibration(600, 600, 300, 200)};
    problem.size1 = {640, 480};
    problem.size2 = {600, 400};
    problem.points.resize(num_points, 4);
    problem.snn_ratio.resize(num_points);
    problem.scale_rotation_changes.resize(num_points, 2);
    problem.descriptors.resize(num_points, 8);
    for (int k = 0; k < num_points; ++k) {
      const Eigen::Vector3d point(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(4, 8));
      problem.points.row(k) << Project(problem.cameras->K1, set.cameras[pair.image1], point).transpose(),
          Project(problem.cameras->K2, set.cameras[pair.image2], point).transpose();
      const bool inlier = k % 3 != 0;
      if (!inlier) problem.points(k, 3) += 50.0, problem.points(k, 2) -= 30.0;
      problem.snn_ratio[k] = rng.Uniform();
      problem.scale_rotation_changes.row(k) << 0.1 * (k % 7) - 0.3, 0.4 * (k % 11) - 2.0;
      for (int d = 0; d < 8; ++d) problem.descriptors(k, d) = static_cast<float>(rng.Uniform());
      pair.truth.assignment.push_back(inlier ? 1 : 0);
    }
    pair.truth.motion = RelativeMotion(set.cameras[pair.image1], set.cameras[pair.image2]);
    CompleteTruth(problem, &pair.truth);
    set.pairs.push_back(std::move(pair));
  }
  return set;
}

}  // namespace diffsac
