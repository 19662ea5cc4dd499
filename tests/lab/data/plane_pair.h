#pragma once

#include <vector>

#include "diffsac/geometry/homography.h"
#include "lab/data/instance_sizes.h"
#include "lab/data/virtual_views.h"
#include "lab/ground_truth/example.h"

namespace diffsac::testing {

/// Two views of as many planes as there are sizes, each with so many matches in an upright strip of image 1, and
/// uniform outliers. With calibrations, ratios, labels and homographies in pixels; ε is 2 px.
inline Example PlanePair(const std::vector<int>& sizes, int outliers, std::uint64_t seed, double noise_px = 0.3) {
  Rng rng(seed);
  VirtualPair pair;
  pair.first = pair.second = RandomCamera({}, rng.Fork("camera"));
  pair.motion = MotionTo(0.6 * RandomDirection(rng), RandomRotation(5.0, rng), 3.0);
  const double width = pair.first.size.width, height = pair.first.size.height;
  const double strip = width / static_cast<double>(sizes.size());
  std::vector<Eigen::Vector4d> matches;
  Example example;
  for (std::size_t k = 0; k < sizes.size();) {
    const Eigen::Vector3d point =
        pair.first.Ray({(static_cast<double>(k) + 0.5) * strip, 0.5 * height}) * (2.0 + static_cast<double>(k));
    VirtualPlane plane;
    plane.normal = Tilted(Eigen::Vector3d::UnitZ(), rng.Uniform(0.0, 40.0), rng);
    plane.distance = plane.normal.dot(point);
    if (!(plane.distance > 0.0 && plane.FacesBoth(pair.motion))) continue;
    std::vector<Eigen::Vector4d> own;
    for (int i = 0; i < 20 * sizes[k] && static_cast<int>(own.size()) < sizes[k]; ++i) {
      const double x = (static_cast<double>(k) + rng.Uniform()) * strip;
      Eigen::Vector4d match;
      if (plane.Match(pair, {1.0, 8.0}, {x, rng.Uniform(0.0, height)}, &match)) own.push_back(match);
    }
    if (static_cast<int>(own.size()) < sizes[k]) continue;
    matches.insert(matches.end(), own.begin(), own.end());
    example.truth.instances.push_back(AsParameters(plane.Homography(pair)));
    example.truth.assignment.resize(matches.size(), static_cast<std::int32_t>(++k));
  }
  const auto inliers = static_cast<Eigen::Index>(matches.size());
  Problem& problem = example.problem;
  problem.task = Task::kHomography;
  problem.inlier_threshold = 2.0;
  problem.cameras = CameraPair{pair.first.K, pair.second.K};
  problem.size1 = problem.size2 = pair.first.size;
  problem.points.resize(inliers + outliers, 4);
  problem.snn_ratio.resize(inliers + outliers);
  for (Eigen::Index i = 0; i < problem.points.rows(); ++i) {
    problem.snn_ratio[i] = i < inliers ? rng.Uniform(0.3, 0.8) : rng.Uniform(0.6, 1.0);
    if (i < inliers)
      for (int c = 0; c < 4; ++c) problem.points(i, c) = matches[i][c] + noise_px * rng.Normal();
    else
      problem.points.row(i) << pair.first.RandomPixel(rng).transpose(), pair.first.RandomPixel(rng).transpose();
  }
  example.truth.assignment.resize(problem.points.rows(), 0);
  ArrangeInstances(1, &example.truth);
  return example;
}

}  // namespace diffsac::testing
