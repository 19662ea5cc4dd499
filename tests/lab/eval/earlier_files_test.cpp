// version_0_1/ holds a small file of each format as version 0.1.0 wrote it (docs/versions.md promises to read them): a
// network trained for 30 steps, its configuration YAML as in the first of them; the correspondences of a pair. They are
// never written again: a later version gets a folder of its own.

#include <catch2/catch.hpp>

#include "lab/config/dataset_factory.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/eval/runner.h"
#include "lab/files/correspondence_files.h"

namespace diffsac {
namespace {

const std::string kFolder = DIFFSAC_SOURCE_DIR "/tests/lab/eval/version_0_1/";

}  // namespace

TEST_CASE("a network of version 0.1.0 estimates as then") {
  const double models[3][3] = {{0.2169522386213436, 0.9761822197505892, -1.8499473341349777},
                               {0.14508264832364623, 0.9894195395055614, -5.166540200417957},
                               {-0.9991756623188507, 0.0405955148961805, 0.25584469870032517}};
  const auto data =
      MakeDataset(ConfigFromYaml("{type: synthetic_line, num_points: 30, split: test, outlier_ratio: 0.5}"), 3);
  const auto network =
      MakeEstimator(ConfigFromYaml("{type: diffsac, checkpoint: '" + kFolder + "model.safetensors'}"), Task::kLine, {});
  for (std::uint64_t k = 0; k < 3; ++k) {
    const Example example = data->Get(k);
    const Estimate estimate = network->Run(example.problem, ProblemSeed(3, example));
    REQUIRE(estimate.status == Status::kOk);
    CHECK((estimate.model - Eigen::Map<const Eigen::Vector3d>(models[k])).norm() < 1e-4);
  }
}

TEST_CASE("correspondence files of version 0.1.0 are read") {
  const CorrespondenceScene scene(kFolder + "views");
  REQUIRE(scene.size() == 1);
  const Example pair = scene.Read(0);
  CHECK(pair.problem.points.rows() == 28);
  CHECK(pair.problem.snn_ratio.size() == 28);
  CHECK(pair.problem.scale_rotation_changes.rows() == 28);
  CHECK(pair.problem.size1.width == 160);
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift(0, 2) = 9.0;
  REQUIRE(pair.truth.homography);
  CHECK(pair.truth.homography->isApprox(shift));
}

}  // namespace diffsac
