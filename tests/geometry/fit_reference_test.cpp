// OpenCV's fitLine (DIST_L2) is an independent implementation of the total least squares line; it works in single
// precision, which sets the tolerance. Planes: the smallest singular vector of the centred points.

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <catch2/catch.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "diffsac/geometry/hyperplane.h"
#include "geometry/random_points.h"

namespace diffsac {
namespace {

TEST_CASE("Line fits agree with OpenCV's fitLine") {
  Rng rng(11);
  for (int trial = 0; trial < 300; ++trial) {
    const double angle = rng.Uniform(0.0, 3.14159);
    const int count = 5 + static_cast<int>(rng.Below(50));
    PointMatrix points(count, 2);
    std::vector<cv::Point2f> opencv_points;
    for (int i = 0; i < count; ++i) {
      const double along = rng.Uniform(-4.0, 4.0), across = 0.1 * rng.Normal();
      // Rounded to single precision, so that both see the same points.
      points(i, 0) = static_cast<float>(5.0 + along * std::cos(angle) - across * std::sin(angle));
      points(i, 1) = static_cast<float>(5.0 + along * std::sin(angle) + across * std::cos(angle));
      opencv_points.emplace_back(static_cast<float>(points(i, 0)), static_cast<float>(points(i, 1)));
    }
    cv::Vec4f fitted;
    cv::fitLine(opencv_points, fitted, cv::DIST_L2, 0, 0.01, 0.01);
    Line::Parameters line;
    REQUIRE(Line::Fit(points, Eigen::VectorXd::Ones(count), &line));
    const double centroid[] = {fitted[2], fitted[3]};
    CHECK(std::abs(line[0] * fitted[0] + line[1] * fitted[1]) < 2e-5);
    CHECK(Line::Residual(line, centroid) < 2e-5);
  }
}

TEST_CASE("Plane fits agree with a singular value decomposition, also far from the origin and for thin noise") {
  Rng rng(12);
  for (double noise : {1e-6, 0.05, 0.5}) {
    for (double distance : {0.0, 1000.0}) {
      CAPTURE(noise, distance);
      for (int trial = 0; trial < 50; ++trial) {
        PointMatrix points = testing::RandomPoints(30, 3, 4.0, rng);
        for (int i = 0; i < 30; ++i)
          points(i, 2) = 0.3 * points(i, 0) - 0.7 * points(i, 1) + noise * rng.Normal() + distance;
        const Eigen::RowVector3d centroid = points.colwise().mean();
        const Eigen::MatrixXd centred = points.rowwise() - centroid;
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(centred, Eigen::ComputeThinV);
        const Eigen::Vector3d normal = svd.matrixV().col(2);
        Plane::Parameters plane;
        REQUIRE(Plane::Fit(points, Eigen::VectorXd::Ones(30), &plane));
        CHECK(plane.head<3>().cross(normal).norm() < 1e-9);
        CHECK(Plane::Residual(plane, centroid.data()) < 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace diffsac
