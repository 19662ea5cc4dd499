// The file of what was estimated: what stands in it, that it reads back, and what is wrong with one that does not.

#include "lab/eval/estimates.h"

#include <H5Cpp.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/errors.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/problem/tasks.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

EstimateRecord Record(int index) {
  EstimateRecord record;
  record.index = index;
  record.id = "pair " + std::to_string(index);
  record.data_scene = "castle";
  record.status = Status::kOk;
  record.model = Eigen::VectorXd::LinSpaced(9, index, index + 1.0);
  record.pose = RigidMotion{Eigen::AngleAxisd(0.1 * index, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {1, 2, 3}};
  for (int i = 0; i < 3 * index; ++i) record.inlier_rows.push_back(2 * i);
  record.points = 100 + index;
  if (index != 1) record.pose_covariance = Eigen::MatrixXd::Identity(6, 6) * (1.0 + index);
  if (index == 2) record.ambiguous_pose = RigidMotion{Eigen::Matrix3d::Identity(), {3, 2, 1}};
  record.cheirality_failure_ratio = 0.01 * index;
  if (index != 4) record.focal = FocalEstimate{{700, 700.0 + index}, {650, 660}, {720, 730}, index == 0};
  record.degeneracy = index == 4 ? Degeneracy::kPureRotation : Degeneracy::kDetermined;
  record.score = 0.5 * index;
  record.sigma = 0.25;
  record.log10_nfa = 2.5 - index;
  record.draws = 1000;
  record.inlier_threshold = 1.0 + index;
  if (index == 2) record.rows = {1, 5, 100000};
  record.inlier_probabilities.assign(100 + index, 0.5f);
  return record;
}

EstimateFile Content() {
  EstimateFile file{"table", "fundamental", "abc", {}};
  file.groups.push_back({"prosac", "ratio 0.85", {Record(0), Record(1), Record(4)}});
  EstimateRecord failed;
  failed.index = 7;
  failed.id = "ü/1";
  failed.status = Status::kTooFewPoints;
  failed.points = 3;
  file.groups.push_back({"net/work", "all", {failed, Record(2)}});
  file.groups.push_back({"net/work", "none", {}});
  EstimateRecord several = Record(3), none = Record(5);
  several.instances = {several.model, 2.0 * several.model, -several.model};
  for (int i = 0; i < several.points; ++i) several.assignment.push_back(i % 4);
  file.groups.push_back({"several", "all", {failed, several, none}});
  several.instance_values = {0.9, 0.7, 0.4};
  file.groups.push_back({"chosen", "all", {failed, several}});
  return file;
}

}  // namespace

TEST_CASE("estimates read back as they were written") {
  TemporaryFolder folder;
  const std::string path = folder / "estimates.h5";
  const EstimateFile written = Content();
  WriteEstimates(path, written);
  const EstimateFile read = ReadEstimates(path);
  CHECK(read.experiment == "table");
  CHECK(read.task == "fundamental");
  CHECK(read.git_revision == "abc");
  REQUIRE(read.groups.size() == 5);
  for (const EstimateGroup& group : written.groups) {
    const auto same = std::find_if(read.groups.begin(), read.groups.end(), [&](const EstimateGroup& other) {
      return other.method == group.method && other.condition == group.condition;
    });
    REQUIRE(same != read.groups.end());
    REQUIRE(same->records.size() == group.records.size());
    for (std::size_t i = 0; i < group.records.size(); ++i) {
      const EstimateRecord &a = group.records[i], &b = same->records[i];
      CHECK(a.index == b.index);
      CHECK(a.id == b.id);
      CHECK(a.data_scene == b.data_scene);
      CHECK(a.status == b.status);
      REQUIRE(a.model.size() == b.model.size());
      CHECK(a.model == b.model);
      CHECK(a.pose == b.pose);
      CHECK(a.pose_covariance == b.pose_covariance);
      CHECK(a.degeneracy == b.degeneracy);
      CHECK(a.ambiguous_pose == b.ambiguous_pose);
      CHECK(a.cheirality_failure_ratio == b.cheirality_failure_ratio);
      REQUIRE(a.focal.has_value() == b.focal.has_value());
      if (a.focal) {
        CHECK(a.focal->focal_px == b.focal->focal_px);
        CHECK(a.focal->low_px == b.focal->low_px);
        CHECK(a.focal->high_px == b.focal->high_px);
        CHECK(a.focal->observable == b.focal->observable);
      }
      CHECK(a.inlier_rows == b.inlier_rows);
      CHECK(a.points == b.points);
      CHECK(a.score == b.score);
      CHECK((a.sigma == b.sigma || (std::isnan(a.sigma) && std::isnan(b.sigma))));
      CHECK((a.log10_nfa == b.log10_nfa || (std::isnan(a.log10_nfa) && std::isnan(b.log10_nfa))));
      CHECK(a.MayBeChance() == b.MayBeChance());
      CHECK(a.draws == b.draws);
      CHECK(a.rows == b.rows);
      CHECK((a.inlier_threshold == b.inlier_threshold ||
             (std::isnan(a.inlier_threshold) && std::isnan(b.inlier_threshold))));
      CHECK(a.instances == b.instances);
      CHECK(a.assignment == b.assignment);
      CHECK(a.instance_values == b.instance_values);
      CHECK(a.inlier_probabilities == b.inlier_probabilities);
    }
  }
}

TEST_CASE("a record has the pose of its model where there is one") {
  Rng rng(3);
  const testing::TwoViewProblem views = testing::RandomProblem(40, rng);
  Example example;
  example.id = "a-b";
  example.problem.task = Task::kEssential;
  example.problem.points = views.pixels;
  example.problem.cameras = CameraPair{views.k1, views.k2};
  Estimate estimate;
  estimate.status = Status::kOk;
  estimate.model = views.essential;
  estimate.inliers.assign(40, 1);
  estimate.inliers[3] = 0;
  estimate.stats.iterations = 77;
  const auto check_pose = [&](const EstimateRecord& record) {
    REQUIRE(record.pose);
    CHECK(RotationAngleDegrees(record.pose->rotation, views.pose.rotation) < 1e-6);
    CHECK(DirectionAngleDegrees(record.pose->translation, views.pose.translation) < 1e-6);
  };
  EstimateRecord record = RecordOf(example, estimate);
  CHECK(record.inlier_rows.size() == 39);
  CHECK(record.inlier_rows[3] == 4);
  check_pose(record);
  example.problem.task = Task::kFundamental;
  estimate.model = views.fundamental;
  check_pose(RecordOf(example, estimate));
  example.problem.cameras.reset();
  CHECK_FALSE(RecordOf(example, estimate).pose);
  estimate.status = Status::kNoModel;
  record = RecordOf(example, estimate);
  CHECK(record.model.size() == 0);
  CHECK(record.points == 40);
  CHECK(record.draws == 77);

  example.problem.task = Task::kAbsolutePose;
  estimate.status = Status::kOk;
  estimate.model = PoseOf(Eigen::Matrix3d::Identity(), Eigen::Vector3d(1, 2, 3));
  CHECK(RecordOf(example, estimate).pose->translation == Eigen::Vector3d(1, 2, 3));
  example.problem.task = Task::kLine;
  estimate.model = Eigen::Vector3d(1, 0, 2);
  CHECK_FALSE(RecordOf(example, estimate).pose);
}

TEST_CASE("what is no file of estimates is said, with its place") {
  TemporaryFolder folder;
  const std::string path = folder / "estimates.h5";
  const auto error = [&] { return ErrorOf([&] { ReadEstimates(path); }); };
  CHECK(Has(error(), "estimates.h5"));
  WriteRaw(path, "text");
  CHECK(Has(error(), "estimates.h5: no estimates"));
  WriteEstimates(path, Content());
  const auto edit = [&](const auto& change) {
    WriteEstimates(path, Content());
    H5::H5File file(path, H5F_ACC_RDWR);
    change(file);
  };
  edit([](H5::H5File& file) { file.unlink("prosac/ratio 0.85/score"); });
  CHECK(Has(error(), "prosac/ratio 0.85: no estimates"));
  edit([](H5::H5File& file) {
    const std::vector<std::int64_t> ends = {0, 99999, 5};
    file.openDataSet("prosac/ratio 0.85/inliers_end").write(ends.data(), H5::PredType::NATIVE_INT64);
  });
  CHECK(Has(error(), "ends that are not in order"));
  edit([](H5::H5File& file) {
    const std::vector<std::int64_t> ends = {-2, 0, 5};
    file.openDataSet("prosac/ratio 0.85/inliers_end").write(ends.data(), H5::PredType::NATIVE_INT64);
  });
  CHECK(Has(error(), "ends that are not in order"));
  // Texts that were never written are null pointers.
  edit([](H5::H5File& file) {
    const hsize_t count = 3;
    file.unlink("prosac/ratio 0.85/status");
    file.createDataSet("prosac/ratio 0.85/status", H5::StrType(H5::PredType::C_S1, H5T_VARIABLE),
                       H5::DataSpace(1, &count));
  });
  CHECK(Has(error(), "unknown status ''"));
  edit([](H5::H5File& file) {
    const hsize_t shape[] = {3, 35};
    file.unlink("prosac/ratio 0.85/pose_covariance");
    file.createDataSet("prosac/ratio 0.85/pose_covariance", H5::PredType::NATIVE_DOUBLE, H5::DataSpace(2, shape));
  });
  CHECK(Has(error(), "pose_covariance: expected a square matrix"));
  edit([](H5::H5File& file) { file.openGroup("/").removeAttr("format"); });
  CHECK(Has(error(), "no estimates of diffsac_eval"));
}

}  // namespace diffsac
