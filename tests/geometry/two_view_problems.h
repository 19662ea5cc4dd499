#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "diffsac/core/random.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac::testing {

/// Two cameras that see the same points, with everything about them.
struct TwoViewProblem {
  Eigen::Matrix3d k1, k2;
  RelativePose pose;
  PointMatrix pixels;      ///< N x 4
  PointMatrix normalized;  ///< N x 4
  Matrix3Parameters essential, fundamental;
};

inline Eigen::Vector3d RandomDirection(Rng& rng) {
  return Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
}

inline Eigen::Matrix3d RandomCamera(Rng& rng) {
  const double focal = rng.Uniform(500.0, 1500.0);
  Eigen::Matrix3d k;
  k << focal, 0.0, rng.Uniform(400.0, 600.0), 0.0, focal, rng.Uniform(300.0, 500.0), 0.0, 0.0, 1.0;
  return k;
}

inline RelativePose RandomPose(Rng& rng, double max_angle = 0.6) {
  RelativePose pose;
  pose.rotation = Eigen::AngleAxisd(rng.Uniform(0.0, max_angle), RandomDirection(rng)).toRotationMatrix();
  pose.translation = RandomDirection(rng);
  return pose;
}

/// `count` points at depths 2 to 10 (baseline 1), before both cameras; `noise` in pixels on every coordinate.
inline TwoViewProblem RandomProblem(int count, Rng& rng, double noise = 0.0) {
  TwoViewProblem problem;
  problem.k1 = RandomCamera(rng);
  problem.k2 = RandomCamera(rng);
  problem.pose = RandomPose(rng);
  problem.pixels.resize(count, 4);
  for (int i = 0; i < count;) {
    const double depth = rng.Uniform(2.0, 10.0);
    const Eigen::Vector3d first(depth * rng.Uniform(-0.6, 0.6), depth * rng.Uniform(-0.6, 0.6), depth);
    const Eigen::Vector3d second = problem.pose.rotation * first + problem.pose.translation;
    if (second[2] < 0.5) continue;
    problem.pixels.row(i) << (problem.k1 * first).hnormalized().transpose(),
        (problem.k2 * second).hnormalized().transpose();
    for (int j = 0; j < 4; ++j) problem.pixels(i, j) += noise * rng.Normal();
    ++i;
  }
  problem.normalized = NormalizedCoordinates(problem.pixels, problem.k1, problem.k2);
  const Eigen::Matrix3d e = EssentialFromPose(problem.pose);
  problem.essential = AsParameters(e);
  problem.fundamental = AsParameters(FundamentalFromEssential(e, problem.k1, problem.k2));
  return problem;
}

/// A homography near the identity that keeps the image's points on one side of its horizon.
inline Matrix3Parameters RandomHomography(Rng& rng) {
  Eigen::Matrix3d h = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) h(i, j) += rng.Uniform(-0.3, 0.3);
  h(0, 2) = rng.Uniform(-200.0, 200.0);
  h(1, 2) = rng.Uniform(-200.0, 200.0);
  h(2, 0) = rng.Uniform(-4e-4, 4e-4);
  h(2, 1) = rng.Uniform(-4e-4, 4e-4);
  return AsParameters(h);
}

inline PointMatrix HomographyPoints(const Matrix3Parameters& model, int count, Rng& rng, double noise = 0.0) {
  const Eigen::Matrix3d h = AsMatrix(model);
  PointMatrix points(count, 4);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d x(rng.Uniform(0.0, 1000.0), rng.Uniform(0.0, 800.0), 1.0);
    points.row(i) << x.head<2>().transpose(), (h * x).hnormalized().transpose();
    for (int j = 0; j < 4; ++j) points(i, j) += noise * rng.Normal();
  }
  return points;
}

/// Distance of two models as unit vectors, whichever sign they have.
inline double ModelDistance(const Matrix3Parameters& a, const Matrix3Parameters& b) {
  return std::min((a - b).norm(), (a + b).norm());
}

/// Distances of models in pixels, measured in coordinates of order one: in pixels the unit norm is all but one entry's,
/// and a difference would say little of the others.
inline double FundamentalDistance(const Matrix3Parameters& a, const Matrix3Parameters& b) {
  const Eigen::DiagonalMatrix<double, 3> pixels(500.0, 500.0, 1.0);
  return ModelDistance(AsParameters(pixels * AsMatrix(a) * pixels), AsParameters(pixels * AsMatrix(b) * pixels));
}
inline double HomographyDistance(const Matrix3Parameters& a, const Matrix3Parameters& b) {
  const Eigen::DiagonalMatrix<double, 3> pixels(500.0, 500.0, 1.0);
  return ModelDistance(AsParameters(pixels.inverse() * AsMatrix(a) * pixels),
                       AsParameters(pixels.inverse() * AsMatrix(b) * pixels));
}

}  // namespace diffsac::testing
