// Every row of the tables of absolute poses on generated scenes, made from YAML by name as the programs make them.

#include <catch2/catch.hpp>
#include <limits>

#include "diffsac/core/random.h"
#include "diffsac/problem/tasks.h"
#include "estimate/make_estimator.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/eval/metrics.h"

namespace diffsac {
namespace {

constexpr const char* kTypes[] = {"ransac",    "lo_ransac", "prosac", "napsac",    "p_napsac",
                                  "gc_ransac", "magsac_pp", "dgsac",  "opencv_pnp"};

std::unique_ptr<Dataset> Scenes() {
  return MakeDataset(ConfigFromYaml("{type: synthetic_absolute_pose, num_points: 150, outlier_ratio: 0.5}", "a.yaml"),
                     3);
}

TEST_CASE("every row finds poses among half outliers") {
  const auto scenes = Scenes();
  for (const char* type : kTypes) {
    const auto method = MakeRow(type, Task::kAbsolutePose);
    int good = 0;
    for (int i = 0; i < 10; ++i) {
      Example example = scenes->Get(i);
      Rng rng(i);
      example.problem.snn_ratio.resize(150);
      for (int k = 0; k < 150; ++k)
        example.problem.snn_ratio[k] = rng.Uniform() + (example.truth.inliers[k] ? 0.0 : 0.3);
      good += MeasureError(method->Run(example.problem, i), example).angle_deg < 1.0;
    }
    CAPTURE(type, good);
    CHECK(good >= 9);
  }
}

TEST_CASE("OpenCV's presets of poses, bad points get a status") {
  const Example example = Scenes()->Get(0);
  for (const char* preset : {"ransac", "default", "accurate", "fast", "magsac", "prosac"}) {
    const auto method = MakeRow("opencv_pnp", Task::kAbsolutePose, std::string("preset: ") + preset);
    CAPTURE(preset);
    const Estimate estimate = method->Run(example.problem, 1);
    CHECK(estimate.status == Status::kOk);
    CHECK(MeasureError(estimate, example).angle_deg < 3.0);
    Problem few = example.problem;
    few.points = few.points.topRows(2).eval();
    CHECK(method->Run(few, 1).status == Status::kTooFewPoints);
    few.points = example.problem.points.topRows(3);
    CHECK_NOTHROW(method->Run(few, 1));
    Problem broken = example.problem;
    broken.points(3, 4) = std::numeric_limits<double>::quiet_NaN();
    CHECK(method->Run(broken, 1).num_nonfinite == 1);
    Problem blind = example.problem;
    blind.cameras.reset();
    CHECK(method->Run(blind, 1).status == Status::kDegenerate);
  }
}

TEST_CASE("rows of other tasks say so, and those of poses elsewhere") {
  CHECK_THROWS_WITH(MakeRow("usac", Task::kAbsolutePose), Catch::Contains("two-view models only"));
  CHECK_THROWS_WITH(MakeRow("theil_sen", Task::kAbsolutePose), Catch::Contains("lines and planes only"));
  CHECK_THROWS_WITH(MakeRow("opencv_pnp", Task::kLine), Catch::Contains("absolute poses only"));
}

}  // namespace
}  // namespace diffsac
