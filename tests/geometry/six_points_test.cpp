#include "diffsac/geometry/six_points.h"

#include <catch2/catch.hpp>
#include <limits>

#include "geometry/unknown_focal_scene.h"

namespace diffsac {
namespace {

using testing::FocalModelDistance;
using testing::MakeUnknownFocalScene;

template <UnknownFocal kUnknown>
int Solve(const PointMatrix& points, FocalParameters* out) {
  double p[6][4];
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 4; ++j) p[i][j] = points(i, j);
  return SolveSixPoints<kUnknown>(p, out);
}

template <UnknownFocal kUnknown>
void CheckRecovers() {
  Rng rng(1);
  int recovered = 0, all = 0;
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto scene = MakeUnknownFocalScene(kUnknown, 6, rng);
    FocalParameters models[MaxSixPointSolutions(kUnknown)];
    const int count = Solve<kUnknown>(scene.points, models);
    all += count;
    double best = 9.0;
    for (int k = 0; k < count; ++k) {
      best = std::min(best, FocalModelDistance(models[k], scene.model));
      const Matrix3Parameters essential = models[k].template head<9>();
      const Eigen::Matrix3d e = AsMatrix(essential);
      CHECK((2.0 * e * e.transpose() * e - (e * e.transpose()).trace() * e).norm() < 1e-7);
      for (int i = 0; i < 6; ++i) {
        const Eigen::Matrix3d f = AsMatrix(FundamentalOf(kUnknown, models[k]));
        const Eigen::Vector3d x1(scene.points(i, 0), scene.points(i, 1), 1.0);
        const Eigen::Vector3d x2(scene.points(i, 2), scene.points(i, 3), 1.0);
        CHECK(std::abs(x2.dot(f * x1)) < 1e-10 * std::max(1.0, f.norm()));
      }
    }
    recovered += best < 1e-6 ? 1 : 0;
  }
  CAPTURE(all, recovered);
  CHECK(recovered >= 0.99 * kTrials);
  CHECK(all > 2 * kTrials);
}

}  // namespace

TEST_CASE("the six-point solvers recover E and f, and all they give are solutions") {
  CheckRecovers<UnknownFocal::kBoth>();
  CheckRecovers<UnknownFocal::kSecond>();
}

TEST_CASE("the six-point solver of a shared focal length has PoseLib's solutions") {
  // PoseLib 2.0.5, shared_focal_relpose_6pt of these points: each a focal length, R and t.
  PointMatrix points(6, 4);
  points << -0.38, -0.02, -0.57, -0.25, -0.22, -0.28, -0.37, -0.48, 0.23, 0.18, -0.04, 0.06, 0.05, -0.26, -0.13, -0.39,
      -0.41, -0.11, -0.57, -0.35, -0.05, 0.01, -0.26, -0.14;
  struct Solution {
    double focal;
    double rotation[9], translation[3];
  };
  const Solution golden[] = {
      {0.6075603732538384,
       {0.9766093899184104, -0.21143656781845607, -0.03909830319005782, 0.2135996206526559, 0.9331052725673378,
        0.28929181178193736, -0.024684034926076306, -0.2908764825423083, 0.9564421416497615},
       {-0.5060059767538901, -0.859205588101347, 0.07565519720918144}},
      {2.611569225374325,
       {0.973135569341926, -0.21639146358981212, -0.07862504796198509, 0.21292511204531953, 0.9757791842609553,
        -0.05017848367091864, 0.08757888068509188, 0.03208922012893966, 0.9956406086582964},
       {-0.1402465005604308, -0.18852593094158507, 0.9720025166856112}}};
  FocalParameters models[15];
  const int count = Solve<UnknownFocal::kBoth>(points, models);
  for (const Solution& solution : golden) {
    RelativePose pose;
    pose.rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(solution.rotation);
    pose.translation = Eigen::Map<const Eigen::Vector3d>(solution.translation);
    const FocalParameters model = AsFocalParameters(AsParameters(EssentialFromPose(pose)), solution.focal);
    double best = 9.0;
    for (int k = 0; k < count; ++k) best = std::min(best, FocalModelDistance(models[k], model));
    CHECK(best < 1e-7);
  }
}

TEST_CASE("sets that determine nothing have no six-point solution") {
  Rng rng(2);
  FocalParameters models[15];
  const auto scene = MakeUnknownFocalScene(UnknownFocal::kBoth, 6, rng);
  PointMatrix twice = scene.points;
  twice.row(5) = twice.row(0);
  CHECK(Solve<UnknownFocal::kBoth>(twice, models) == 0);
  PointMatrix equal = scene.points.row(0).replicate(6, 1);
  CHECK(Solve<UnknownFocal::kBoth>(equal, models) == 0);
  PointMatrix broken = scene.points;
  broken(3, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK(Solve<UnknownFocal::kBoth>(broken, models) == 0);
  CHECK(Solve<UnknownFocal::kSecond>(broken, models) == 0);
}

}  // namespace diffsac
