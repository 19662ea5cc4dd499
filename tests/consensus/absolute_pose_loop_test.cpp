// The loop on absolute poses: a model that the loop's own files do not name.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "consensus/absolute_pose_scene.h"
#include "consensus/search.h"

namespace diffsac {
namespace {

using testing::MakeAbsolutePoseScene;
using testing::SearchUniformly;

constexpr double kThreshold = 3e-3, kNoise = 1e-3;

ConsensusOptions Options() {
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMsac;
  options.local_optimization = LocalOptimization::kInnerSamples;
  options.refit = Refit::kIterated;
  options.final_refinement = FinalRefinement::kRefinement;
  options.stopping = Stopping::kConfidence;
  options.confidence = 0.9999;
  return options;
}

TEST_CASE("Absolute poses are recovered from 20 to 70 % outliers, by any score and optimiser") {
  for (const double outliers : {0.2, 0.5, 0.7})
    for (const auto& [optimizer, name] : kEnumNames<LocalOptimization>) {
      CAPTURE(outliers, name);
      ConsensusOptions options = Options();
      options.local_optimization = optimizer;
      int recovered = 0;
      for (int trial = 0; trial < 20; ++trial) {
        const auto scene = MakeAbsolutePoseScene(100, outliers, kNoise, Rng(trial).Fork("scene"));
        const auto result = SearchUniformly<AbsolutePose>(scene.points, kThreshold, options, Rng(trial));
        if (result.status != Status::kOk) continue;
        const AbsolutePose::Parameters pose = result.model;
        const Eigen::AngleAxisd turn(RotationOf(pose).transpose() * RotationOf(scene.truth));
        int both = 0, all = 0;
        for (int i = 0; i < 100; ++i) {
          all += scene.inliers[i];
          both += scene.inliers[i] && result.inliers[i];
        }
        recovered += turn.angle() < 0.01 && both > 0.9 * all ? 1 : 0;
      }
      CHECK(recovered >= 19);
    }
}

TEST_CASE("Hostile points of absolute poses give a status") {
  const auto good = MakeAbsolutePoseScene(30, 0.0, kNoise, Rng(1));
  const auto status = [&](const PointMatrix& points) {
    return SearchUniformly<AbsolutePose>(points, kThreshold, Options(), Rng(1)).status;
  };
  CHECK(status(good.points) == Status::kOk);
  CHECK(status(good.points.topRows(3)) == Status::kOk);
  for (const int count : {0, 1, 2}) CHECK(status(good.points.topRows(count)) == Status::kTooFewPoints);
  CHECK(status(good.points.row(0).replicate(30, 1)) == Status::kDegenerate);
  CHECK(status(good.points.leftCols(4)) == Status::kDegenerate);
  PointMatrix collinear = good.points;
  for (int i = 0; i < 30; ++i) collinear.row(i).head<3>() = Eigen::RowVector3d(i, 2.0 * i, 3.0);
  CHECK(status(collinear) == Status::kDegenerate);
  PointMatrix broken = good.points;
  broken(4, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK(status(broken) == Status::kDegenerate);
}

}  // namespace
}  // namespace diffsac
