// Matches of two clouds that somebody else made: read, estimated, told.
#include "lab/registration/matched_motion.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/temporary_folder.h"
#include "diffsac/core/random.h"
#include "diffsac/geometry/pose.h"
#include "lab/files/files.h"
#include "lab/images/given_matches.h"

namespace diffsac {
namespace {

const Eigen::Vector3d kTranslation(3.0, -2.0, 1.0);
Eigen::Matrix3d Turn() { return Eigen::AngleAxisd(0.9, Eigen::Vector3d(1.0, 2.0, -1.0).normalized()).matrix(); }

/// 200 matches, x1 y1 z1 x2 y2 z2, of which the last hundred are wrong.
PointMatrix Rows(double scale) {
  Rng rng(2);
  PointMatrix rows(200, 6);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    Eigen::Vector3d first, noise, second;
    for (int k = 0; k < 3; ++k) {
      first[k] = rng.Uniform(-5.0, 5.0);
      noise[k] = 0.01 * rng.Normal();
      second[k] = rng.Uniform(-8.0, 8.0);
    }
    if (i < 100) second = scale * Turn() * first + kTranslation + noise;
    rows.row(i) << first.transpose(), second.transpose();
  }
  return rows;
}

std::string TextOf(const PointMatrix& rows) {
  std::ostringstream text;
  text.precision(17);
  for (const auto& row : rows.rowwise()) text << row << "\n";
  return text.str();
}

struct Files {
  TemporaryFolder folder;
  Matches3D3D Read(const std::string& text) const {
    WriteFileAtomically(folder.File("m.csv"), text);
    return ReadCloudMatches(folder.File("m.csv"));
  }
};

}  // namespace

TEST_CASE("matches in a file give the motion, and with a scale the similarity, with what is sure of it") {
  const Files files;
  for (const auto& [task, scale] : {std::pair(Task::kRigid, 1.0), std::pair(Task::kSimilarity, 2.5)}) {
    const MatchedMotion found = EstimateMatched(task, files.Read(TextOf(Rows(scale))), {});
    REQUIRE(found.estimate.ok());
    CHECK(found.matches == 200);
    CHECK(found.estimate.num_inliers >= 95);
    CHECK(found.estimate.verdict == Verdict::kReliable);
    CHECK(RotationAngleDegrees(found.estimate.pose->rotation, Turn()) < 0.1);
    CHECK((found.estimate.pose->translation - kTranslation).norm() < 0.02);
    CHECK(found.scale == Approx(scale).epsilon(1e-3));
    const auto json = nlohmann::json::parse(MatchedJson("m.csv", found));
    CHECK(json["covariance"].size() == (task == Task::kRigid ? 6 : 7));
    CHECK(json["inlier_rows"].size() == static_cast<std::size_t>(found.estimate.num_inliers));
    CHECK(json["posteriors"].size() == 200);
    CHECK(json.contains("scale") == (task == Task::kSimilarity));
    CHECK(MotionText(found, *found.estimate.pose).find(task == Task::kRigid ? "rigid motion: " : "similarity: ") !=
          std::string::npos);
  }
}

TEST_CASE("the covariance told is of the t told") {
  const Eigen::Vector3d far(331250.0, 5712480.0, 105.0);
  const auto matches = [](const PointMatrix& rows) { return Matches3D3D{rows.leftCols(3), rows.rightCols(3)}; };
  for (const auto& [task, scale] : {std::pair(Task::kRigid, 1.0), std::pair(Task::kSimilarity, 2.5)}) {
    PointMatrix rows = Rows(scale);
    const MatchedMotion near = EstimateMatched(task, matches(rows), RegistrationOptions{.max_residual = 0.05});
    rows.leftCols(3).rowwise() += far.transpose();
    const MatchedMotion there = EstimateMatched(task, matches(rows), RegistrationOptions{.max_residual = 0.05});
    const RigidMotion& motion = *there.estimate.pose;
    // As of scans: estimated about a middle, told between the files' frames.
    const auto about = SpreadOf(near, motion, far), of_near = SpreadOf(near, *near.estimate.pose),
               of_far = SpreadOf(there, motion);
    REQUIRE((about && of_near && of_far));
    const auto same = [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
      return (a - b).norm() < 0.01 * b.norm();
    };
    CHECK(of_near->of_t == *near.estimate.pose_covariance);
    CHECK(of_far->of_t == *there.estimate.pose_covariance);
    CHECK(same(about->of_t, of_far->of_t));
    CHECK(same(about->of_middle, of_near->of_middle));
    CHECK(same(of_far->of_middle, of_near->of_middle));
    CHECK((of_far->middle - of_near->middle - far).norm() < 1e-3);
    const auto sigma = [](const Eigen::MatrixXd& covariance) {
      return std::sqrt(covariance.block<3, 3>(3, 3).trace());
    };
    const Eigen::Vector3d truth = kTranslation - scale * Turn() * far;
    CHECK((motion.translation - truth).norm() < 4.0 * sigma(about->of_t));
    CHECK(sigma(about->of_t) > 100.0);
    CHECK(sigma(about->of_middle) < 0.01);
    const auto json = nlohmann::json::parse(MotionJson(near, motion, far).dump());
    CHECK(json["covariance"][3][3] == about->of_t(3, 3));
    CHECK(json["covariance_at_middle"][3][3] == about->of_middle(3, 3));
    CHECK(json["middle"][1] == about->middle[1]);
    CHECK(MotionText(near, motion, far).find("the middle of the inliers, (3312") != std::string::npos);
  }
}

TEST_CASE("columns of matches are found by their names, and scores are none of the ratios") {
  const Files files;
  const Matches3D3D plain = files.Read("1 2 3 4 5 6 0.5\n7 8 9 10 11 nan 1\n");
  CHECK(plain.points1.matrix().row(1) == Eigen::RowVector3d(7.0, 8.0, 9.0));
  CHECK(plain.snn_ratio.matrix() == Eigen::Vector2d(0.5, 1.0));
  CHECK(plain.scores.empty());
  const Matches3D3D named = files.Read("score,x2,y2,z2,id,z1,y1,x1\n0.25,4,5,6,0,3,2,1\n");
  CHECK(named.points1.matrix().row(0) == Eigen::RowVector3d(1.0, 2.0, 3.0));
  CHECK(named.points2.matrix().row(0) == Eigen::RowVector3d(4.0, 5.0, 6.0));
  CHECK(named.scores.matrix() == Eigen::VectorXd::Constant(1, 0.25));
  CHECK(named.snn_ratio.empty());
}

TEST_CASE("matches without a motion have a status, and files that hold none name the line") {
  const Files files;
  const PointMatrix rows = Rows(1.0);
  PointMatrix line = PointMatrix::Zero(50, 6);
  line.col(0) = line.col(5) = Eigen::VectorXd::LinSpaced(50, 0.0, 10.0);
  PointMatrix plane = rows;
  plane.col(2).setZero();
  plane.col(5).setZero();
  for (const Task task : {Task::kRigid, Task::kSimilarity}) {
    const auto status = [&](const PointMatrix& few) {
      return EstimateMatched(task, files.Read(TextOf(few)), {}).estimate.status;
    };
    CHECK(status(rows.topRows(1)) == Status::kTooFewPoints);
    CHECK(status(rows.topRows(2)) == Status::kTooFewPoints);
    CHECK(status(PointMatrix::Constant(9, 6, std::nan(""))) == Status::kTooFewPoints);
    CHECK(status(line) == Status::kDegenerate);
    CHECK(status(PointMatrix::Ones(50, 6)) == Status::kDegenerate);
    const MatchedMotion three = EstimateMatched(task, files.Read(TextOf(rows.topRows(3))), {});
    CHECK((!three.estimate.ok() || three.estimate.verdict == Verdict::kUnsupported));
  }
  CHECK(nlohmann::json::parse(MatchedJson("m", EstimateMatched(Task::kRigid, {}, {})))["status"] == "too_few_points");
  for (const auto& [text, message] :
       {std::pair("", "m.csv: no matches"), std::pair("1 2 3 4 5\n", "m.csv:1: expected 6 to 8 columns, found 5"),
        std::pair("1 2 3 4 5 6\n1 2 3 x 5 6\n", "m.csv:2: expected a number, found 'x'"),
        std::pair("1 2 3 4 5 6\n1 2 3 4 5\n", "m.csv:2: expected 6 columns"),
        std::pair("1 2 3 4 5 6 1.5\n", "match 1: expected a ratio")})
    CHECK_THROWS_WITH(files.Read(text), Catch::Contains(message));
  CHECK_THROWS_WITH(ReadCloudMatches(files.folder.File("none.csv")), Catch::Contains("none.csv"));
}

TEST_CASE("several motions in a file are told with the matches of each") {
  PointMatrix rows = Rows(1.0);
  for (Eigen::Index i = 100; i < 180; ++i) rows.row(i).tail(3) = rows.row(i).head(3).reverse() * -1.0;
  const Matches3D3D matches = Files().Read(TextOf(rows));
  const auto found = EstimateMultipleRigidMotions(matches);
  REQUIRE(found.models.size() == 2);
  const auto json = nlohmann::json::parse(MotionsJson("m.csv", found));
  CHECK(json["motions"].size() == 2);
  CHECK(json["assignment"].size() == 200);
  CHECK(MotionsText(found).find("rigid motion 2: 80 matches") != std::string::npos);
  const auto none = EstimateMultipleRigidMotions({});
  CHECK(MotionsText(none).find("no motion: ") != std::string::npos);
}

}  // namespace diffsac
