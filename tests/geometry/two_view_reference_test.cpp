// OpenCV as an independent reference for all solutions of minimal sets, on clean data. (That the true one is among
// them, and that fits, decompositions and poses give it back, the solvers' own tests say.)

#include <algorithm>
#include <catch2/catch.hpp>
#include <opencv2/calib3d.hpp>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::FundamentalDistance;
using testing::ModelDistance;
using testing::RandomProblem;

/// OpenCV's F and H take single-precision points; so that both see the same ones.
PointMatrix SinglePrecision(const PointMatrix& points) { return points.cast<float>().cast<double>(); }

cv::Mat ImagePoints(const PointMatrix& points, int image) {
  cv::Mat out(static_cast<int>(points.rows()), 2, CV_64F);
  for (int i = 0; i < out.rows; ++i)
    for (int j = 0; j < 2; ++j) out.at<double>(i, j) = points(i, 2 * image + j);
  return out;
}

Eigen::Matrix3d ToEigen(const cv::Mat& mat, int first_row = 0) {
  Eigen::Matrix3d out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out(i, j) = mat.at<double>(first_row + i, j);
  return out;
}

TEST_CASE("OpenCV's 7-point algorithm has the same solutions") {
  Rng rng(1);
  const int set[] = {0, 1, 2, 3, 4, 5, 6};
  int compared = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const PointMatrix points = SinglePrecision(RandomProblem(7, rng).pixels);
    const cv::Mat f = cv::findFundamentalMat(ImagePoints(points, 0), ImagePoints(points, 1), cv::FM_7POINT);
    Matrix3Parameters models[3];
    const int count = SolveSevenPoints(points, set, models);
    if (f.rows != 3 * count) continue;  // a near-double root may be counted either way
    for (int i = 0; i < count; ++i) {
      double best = 2.0;
      for (int j = 0; j < count; ++j)
        best = std::min(best, FundamentalDistance(models[i], AsParameters(ToEigen(f, 3 * j))));
      compared += best < 1e-5 ? 1 : 0;
      // OpenCV does not normalise the points of its 7-point algorithm: solutions far from the data differ more.
      CHECK(best < 1e-3);
    }
  }
  CHECK(compared > 600);
}

TEST_CASE("OpenCV's 5-point algorithm has the same solutions") {
  Rng rng(6);
  const int set[] = {0, 1, 2, 3, 4};
  int same_count = 0, compared = 0, agreed = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto problem = RandomProblem(5, rng);
    const cv::Mat e = cv::findEssentialMat(ImagePoints(problem.normalized, 0), ImagePoints(problem.normalized, 1),
                                           cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, 0.999, 1e-6);
    Matrix3Parameters models[10];
    const int count = SolveFivePoints(problem.normalized, set, models);
    same_count += e.rows == 3 * count ? 1 : 0;
    for (int j = 0; j < e.rows / 3; ++j) {
      double best = 2.0;
      for (int i = 0; i < count; ++i) best = std::min(best, ModelDistance(models[i], AsParameters(ToEigen(e, 3 * j))));
      ++compared;
      agreed += best < 1e-6 ? 1 : 0;
    }
  }
  CAPTURE(same_count, compared, agreed);
  CHECK(compared > 1000);
  CHECK(same_count >= 290);  // a near-double root may be counted either way
  CHECK(agreed >= 0.99 * compared);
}

}  // namespace
}  // namespace diffsac
