// Two clouds of files, or several: the motion, what is said where there is none, the pose graph.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <sstream>

#include "core/temporary_folder.h"
#include "diffsac/core/random.h"
#include "diffsac/geometry/pose.h"
#include "lab/files/files.h"
#include "lab/registration/registration_text.h"

namespace diffsac {
namespace {

RigidMotion MotionOf(double degrees, const Eigen::Vector3d& axis, const Eigen::Vector3d& translation) {
  return {Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis.normalized()).toRotationMatrix(), translation};
}

/// What a scanner sees of twenty boxes that stand around it (no box hides another), those points with low < x < high;
/// other seeds draw other points of the same boxes.
PointMatrix Room(const Eigen::Vector3d& scanner, double low, double high, std::uint64_t seed) {
  Rng boxes(4), places(seed);
  std::vector<Eigen::Vector3d> points;
  for (int b = 0; b < 20; ++b) {
    Eigen::Vector3d centre, half;
    for (int k = 0; k < 3; ++k) {
      centre[k] = boxes.Normal();
      half[k] = boxes.Uniform(0.2, 0.6);
    }
    centre *= boxes.Uniform(2.0, 3.0) / centre.norm();
    const Eigen::Matrix3d turn =
        MotionOf(boxes.Uniform(0.0, 90.0), Eigen::Vector3d(0.2, 0.1, 1.0), Eigen::Vector3d::Zero()).rotation;
    for (int i = 0; i < 4000; ++i) {
      Eigen::Vector3d on(places.Uniform(-1.0, 1.0), places.Uniform(-1.0, 1.0), places.Uniform(-1.0, 1.0));
      const auto face = static_cast<Eigen::Index>(places.Below(3));
      on[face] = on[face] < 0.0 ? -1.0 : 1.0;
      const Eigen::Vector3d point = centre + turn * on.cwiseProduct(half);
      const bool seen = on[face] * turn.col(face).dot(scanner - point) > 0.0;
      if (seen && point[0] > low && point[0] < high) points.push_back(point);
    }
  }
  PointMatrix rows(static_cast<Eigen::Index>(points.size()), 3);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) = points[static_cast<std::size_t>(i)];
  return rows;
}

const Eigen::Vector3d kScanner1(0.3, 0.1, 0.0), kScanner2(-0.3, 0.0, 0.1);
PointMatrix Whole() { return Room(Eigen::Vector3d::Zero(), -9.0, 9.0, 1); }

PointMatrix Moved(const PointMatrix& points, const RigidMotion& motion) {
  return (points * motion.rotation.transpose()).rowwise() + motion.translation.transpose();
}

std::string Written(const TemporaryFolder& folder, const std::string& name, const PointMatrix& points,
                    const std::string& more = "") {
  std::ostringstream text;
  text.precision(12);
  for (const auto& row : points.rowwise()) text << row << "\n";
  WriteFileAtomically(folder.File(name), text.str() + more);
  return folder.File(name);
}

Registration Registered(const std::string& first, const std::string& second) {
  ScanPlan plan = PlanScans({first, second});
  if (plan.voxel > 0.0) plan.voxel = 0.05;
  return RegisterScans(ReadScan(first, plan), ReadScan(second, plan), RegistrationOptions{.max_residual = 0.1});
}

void CheckNear(const RigidMotion& found, const RigidMotion& truth, const Eigen::Vector3d& place) {
  CHECK(RotationAngleDegrees(found.rotation, truth.rotation) < 1.0);
  CHECK((found.rotation * place + found.translation - truth.rotation * place - truth.translation).norm() < 0.03);
}

}  // namespace

TEST_CASE("two views of a room that share a part are moved onto each other, wherever their origins are") {
  const TemporaryFolder folder;
  const PointMatrix room = Room(kScanner1, -9.0, 1.5, 1).rowwise() - kScanner1.transpose();
  RigidMotion second_frame = MotionOf(70.0, {0.3, -0.2, 1.0}, Eigen::Vector3d::Zero());
  second_frame.translation = -second_frame.rotation * kScanner2;
  const std::string second = Written(folder, "second.xyz", Moved(Room(kScanner2, -1.5, 9.0, 2), second_frame));
  RigidMotion truth = second_frame;
  truth.translation += truth.rotation * kScanner1;
  const Eigen::Vector3d far(3e5, -4e6, 100.0);
  for (const Eigen::Vector3d& origin : {Eigen::Vector3d(0.0, 0.0, 0.0), far}) {
    CAPTURE(origin.transpose());
    const std::string first = Written(folder, "first.xyz", room.rowwise() + origin.transpose(), "nan 1 2\n");
    truth.translation -= truth.rotation * origin;
    const Registration found = Registered(first, second);
    REQUIRE(found.estimate.ok());
    CHECK(found.estimate.verdict != Verdict::kUnsupported);
    CheckNear(found.motion, truth, origin);
    CHECK_FALSE(found.slides());
    CHECK(found.overlap1 > 0.3);
    CHECK(found.overlap1 < 0.9);
    CHECK(found.overlap1 >= found.overlap_before);
    const Registration again = Registered(first, second);
    CHECK(again.motion == found.motion);
    CHECK(ReadScan(first, {0.05}).left_out == 1);
  }
}

TEST_CASE("clouds without a motion have a status, and files that are none an error") {
  const TemporaryFolder folder;
  const std::string room = Written(folder, "room.xyz", Whole());
  for (const int count : {1, 2, 3}) {
    const std::string few = Written(folder, "few.xyz", PointMatrix::Random(count, 3));
    CAPTURE(count);
    if (count < 3) CHECK(Registered(few, few).estimate.status == Status::kTooFewPoints);
    const Registration found = Registered(few, room);
    CHECK((!found.estimate.ok() || found.estimate.verdict == Verdict::kUnsupported));
  }
  PointMatrix line = PointMatrix::Zero(100, 3);
  line.col(1) = Eigen::VectorXd::LinSpaced(100, 0.0, 10.0);
  const std::string lines = Written(folder, "line.xyz", line);
  CHECK_FALSE(Registered(lines, lines).estimate.ok());
  const std::string place = Written(folder, "place.xyz", PointMatrix::Ones(50, 3));
  CHECK(PlanScans({place}).voxel == 0.0);
  CHECK(Registered(place, place).estimate.status == Status::kTooFewPoints);
  CHECK_THROWS_WITH(ReadScan(Written(folder, "nan.xyz", PointMatrix(0, 3), "nan nan nan\n"), {0.1}),
                    Catch::Contains("nan.xyz: no point"));
  CHECK_THROWS_WITH(ReadScan(folder.File("none.ply"), {0.1}), Catch::Contains("none.ply: no such file"));
  CHECK_THROWS_WITH(ReadScan(Written(folder, "text.ply", PointMatrix(0, 3), "no cloud"), {0.1}),
                    Catch::Contains("text.ply: no points"));
  CHECK_THROWS_WITH(ReadScan(Written(folder, "cloud.txt", line), {0.1}), Catch::Contains("expected a name"));
  CHECK_THROWS_WITH(ScansOfFolder(folder.File("none")), Catch::Contains("no such folder"));
  CHECK_THROWS_WITH(ReadScan(room, {1e-12}), Catch::Contains("too small"));
}

TEST_CASE("a suitable voxel leaves at most 10 000 points, and grows with the cloud") {
  const TemporaryFolder folder;
  const PointMatrix room = Whole();
  const std::string file = Written(folder, "room.xyz", room);
  const double voxel = PlanScans({file}).voxel;
  const Eigen::Index points = ReadScan(file, {voxel}).descriptors.rows();
  CHECK(points <= 10000);
  CHECK(points > 2000);
  CHECK(PlanScans({Written(folder, "large.xyz", 1000.0 * room)}).voxel == Approx(1000.0 * voxel).epsilon(0.02));
}

TEST_CASE("information matrices are of g2o's errors: what is added in the first scan's frame") {
  Registration registration;
  registration.motion = MotionOf(50.0, {1.0, 2.0, 3.0}, {4.0, 5.0, 6.0});
  CHECK_FALSE(Information(registration, Eigen::Vector3d::Zero()).has_value());
  const Eigen::MatrixXd root = Eigen::MatrixXd::Random(6, 6);
  registration.estimate.pose_covariance = root * root.transpose() + Eigen::MatrixXd::Identity(6, 6);
  const Eigen::Vector3d middle(7.0, -8.0, 9.0);
  const auto information = Information(registration, middle);
  REQUIRE(information);
  const Eigen::Matrix<double, 6, 1> error = 1e-6 * Eigen::Matrix<double, 6, 1>::Random();
  // The motion with the error, and by how much it differs about the middle.
  const Eigen::Vector3d turn = 2.0 * error.tail<3>();
  const RigidMotion added = MotionOf(turn.norm() * 180.0 / std::numbers::pi, turn, error.head<3>());
  const Eigen::Matrix3d& R = registration.motion.rotation;
  const Eigen::AngleAxisd differs(Eigen::Matrix3d(R * added.rotation * R.transpose()));
  Eigen::VectorXd of_covariance(6);
  of_covariance << differs.angle() * differs.axis(), R * (added.rotation * middle + added.translation - middle);
  const double expected = of_covariance.dot(registration.estimate.pose_covariance->inverse() * of_covariance);
  CHECK(error.dot(*information * error) == Approx(expected).epsilon(1e-4));
}

TEST_CASE("a pose graph has a pose for each scan that fits its edges, and a group for scans that none connects") {
  std::vector<RigidMotion> poses;  // Scan to world.
  std::vector<Scan> scans(4);
  for (int i = 0; i < 4; ++i) {
    poses.push_back(i == 0 ? RigidMotion{} : MotionOf(20.0 * i, {1.0, 1.0 * i, 2.0}, Eigen::Vector3d::Constant(i)));
    scans[i].path = "scan" + std::to_string(i) + ".ply";
  }
  const auto pair = [&](int i, int j, int inliers) {
    Registration found;
    found.estimate.status = Status::kOk;
    found.estimate.num_inliers = inliers;
    found.estimate.log10_nfa = -10.0;
    found.hold = 0.5;
    found.estimate.pose_covariance = Eigen::MatrixXd::Identity(6, 6);
    const RigidMotion back = Inverse(poses[j]);
    found.motion = {back.rotation * poses[i].rotation, back.rotation * poses[i].translation + back.translation};
    return ScanPair{i, j, found};
  };
  std::vector<ScanPair> pairs = {pair(0, 1, 5), pair(0, 2, 50), pair(1, 2, 40), pair(0, 3, 60)};
  pairs[3].registration.estimate.log10_nfa = 1.0;
  std::istringstream text(PoseGraphText(scans, pairs));
  std::string line, word;
  std::vector<RigidMotion> vertices;
  int edges = 0, fixed = 0;
  while (std::getline(text, line)) {
    std::istringstream words(line);
    words >> word;
    if (word == "FIX") ++fixed;
    if (word != "VERTEX_SE3:QUAT" && word != "EDGE_SE3:QUAT") continue;
    int i = 0, j = 0;
    words >> i;
    if (word == "EDGE_SE3:QUAT") words >> j;
    RigidMotion motion;
    Eigen::Quaterniond turn;
    for (double& value : motion.translation) words >> value;
    for (double& value : turn.coeffs()) words >> value;
    motion.rotation = turn.toRotationMatrix();
    if (word == "VERTEX_SE3:QUAT") {
      REQUIRE(i == static_cast<int>(vertices.size()));
      vertices.push_back(motion);
      continue;
    }
    ++edges;
    // g2o: pose of i, then the measurement, is the pose of j.
    const Eigen::Matrix3d rotation = vertices[i].rotation * motion.rotation;
    CHECK((rotation - vertices[j].rotation).norm() < 1e-9);
    CHECK((vertices[i].rotation * motion.translation + vertices[i].translation - vertices[j].translation).norm() <
          1e-9);
    int numbers = 0;
    for (double value = 0.0; words >> value;) ++numbers;
    CHECK(numbers == 21);
  }
  CHECK(edges == 3);
  CHECK(fixed == 2);
  REQUIRE(vertices.size() == 4);
  CHECK((vertices[2].translation - poses[2].translation).norm() < 1e-9);
}

}  // namespace diffsac
