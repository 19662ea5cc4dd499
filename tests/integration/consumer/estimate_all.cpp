// Every function of diffsac/diffsac.h on small problems that have one answer.
#include <diffsac/diffsac.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace {

void Check(bool ok, const char* what) {
  if (ok) return;
  std::fprintf(stderr, "wrong: %s\n", what);
  std::exit(1);
}

struct Scene {
  Eigen::Matrix3d K{{600, 0, 320}, {0, 600, 240}, {0, 0, 1}};
  diffsac::RigidMotion motion;
  diffsac::ScenePoints points;
  diffsac::Matches matches;
};

// 200 points before two cameras; every fourth match is wrong. Flat: on one plane.
Scene MakeScene(bool flat) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Scene scene;
  scene.motion.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d(0.2, 1.0, 0.1).normalized()).toRotationMatrix();
  scene.motion.translation = Eigen::Vector3d(1.0, 0.1, 0.2).normalized();
  const int count = 200;
  scene.points.points3d.resize(count, 3);
  scene.points.points2d.resize(count, 2);
  scene.matches.points1.resize(count, 2);
  scene.matches.points2.resize(count, 2);
  scene.matches.match_ratios.resize(count);
  for (int i = 0; i < count; ++i) {
    const double x = 2.0 * unit(random), y = 1.5 * unit(random), z = flat ? 5.0 + 0.3 * x : 6.0 + 2.0 * unit(random);
    const Eigen::Vector3d X(x, y, z);
    const bool wrong = i % 4 == 0;
    const Eigen::Vector2d first = (scene.K * X).hnormalized();
    Eigen::Vector2d second = (scene.K * (scene.motion.rotation * X + scene.motion.translation)).hnormalized();
    if (wrong) second = Eigen::Vector2d(320 + 300 * unit(random), 240 + 220 * unit(random));
    scene.matches.points1.row(i) = first.transpose();
    scene.matches.points2.row(i) = second.transpose();
    scene.matches.match_ratios[i] = wrong ? 0.9 : 0.5;
    scene.points.points3d.row(i) = X.transpose();
    scene.points.points2d.row(i) = second.transpose();
  }
  return scene;
}

double AngleDeg(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(a * b.transpose())).angle() * 180.0 / 3.14159265358979;
}

void TwoViews() {
  const Scene scene = MakeScene(false), wall = MakeScene(true);
  for (const bool network : {true, false}) {
    diffsac::ImageOptions options;
    options.use_network = network;
    const auto e = diffsac::EstimateEssential(scene.matches, {scene.K, scene.K}, options);
    Check(e.ok() && e.num_inliers >= 150 && !e.may_be_chance(), "essential matrix");
    Check(e.pose && AngleDeg(e.pose->rotation, scene.motion.rotation) < 0.01, "pose");
    Check(e.inlier_probabilities.size() == (network ? 200u : 0u), "probabilities");
    Check(e.cost.hypotheses > 0, "cost");
    const auto f = diffsac::EstimateFundamental(scene.matches, options);
    Check(f.ok() && f.num_inliers >= 150 && !f.pose, "fundamental matrix");
    const auto h = diffsac::EstimateHomography(wall.matches, options);
    Check(h.ok() && h.num_inliers >= 150, "homography");
    const Eigen::Vector2d moved = (h.model * wall.matches.points1.row(1).transpose().homogeneous()).hnormalized();
    Check((moved - wall.matches.points2.row(1).transpose()).norm() < 1e-3, "transfer");
  }
  const auto several = diffsac::EstimateHomographies(wall.matches);
  Check(several.ok() && several.models.size() == 1 && several.assignment.size() == 200, "homographies");
  Check(diffsac::EstimateFundamentals(scene.matches).ok(), "fundamental matrices");
  Check(diffsac::EstimateEssentials(scene.matches, {scene.K, scene.K}).ok(), "essential matrices");
  const auto pose = diffsac::EstimateAbsolutePose(scene.points, scene.K);
  Check(pose.ok() && AngleDeg(pose.pose.rotation, scene.motion.rotation) < 0.01, "absolute pose");
  Check(diffsac::EstimateAbsolutePoses(scene.points, scene.K).ok(), "absolute poses");
}

void Points() {
  Eigen::Matrix<double, Eigen::Dynamic, 2> line(40, 2);
  Eigen::Matrix<double, Eigen::Dynamic, 3> plane(60, 3);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0.0, 10.0);
  for (int i = 0; i < 40; ++i) line.row(i) << 0.25 * i, i % 4 ? 0.125 * i + 1.0 : unit(random);
  for (int i = 0; i < 60; ++i) plane.row(i) << unit(random), unit(random), i % 4 ? 2.0 : unit(random);
  const auto l = diffsac::EstimateLine(line, diffsac::PointOptions(0.1));
  Check(l.ok() && std::abs(-l.model[0] / l.model[1] - 0.5) < 1e-6 && l.num_inliers >= 30, "line");
  const auto p = diffsac::EstimatePlane(plane, diffsac::PointOptions(0.1));
  Check(p.ok() && std::abs(std::abs(p.model[2]) - 1.0) < 1e-6, "plane");
  Check(diffsac::EstimateLines(line, diffsac::PointOptions(0.1)).models.size() == 1, "lines");
  Check(diffsac::EstimatePlanes(plane, diffsac::PointOptions(0.1)).models.size() == 1, "planes");
}

// Segments of the three directions of a room.
void VanishingPoints() {
  const Scene scene = MakeScene(false);
  const Eigen::Matrix3d room = Eigen::AngleAxisd(0.6, Eigen::Vector3d(-0.2, 1.0, 0.05).normalized()).toRotationMatrix();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Eigen::Matrix<double, Eigen::Dynamic, 4> segments(90, 4);
  for (int i = 0; i < 90; ++i) {
    const Eigen::Vector3d start(2.0 * unit(random), 1.5 * unit(random), 5.5 + unit(random));
    segments.row(i) << (scene.K * start).hnormalized().transpose(),
        (scene.K * (start + room.col(i % 3))).hnormalized().transpose();
  }
  diffsac::VanishingPointOptions options;
  options.K = scene.K;
  for (const bool network : {true, false}) {
    options.use_network = network;
    const auto found = diffsac::EstimateVanishingPoints(segments, options);
    Check(found.ok() && found.points.size() == 3 && found.horizon, "vanishing points");
    Check(found.values.size() == (network ? 3u : 0u), "values");
    for (int axis = 0; axis < 3; ++axis) {
      double most = 0.0;
      for (const auto& direction : found.directions) most = std::max(most, std::abs(direction.dot(room.col(axis))));
      Check(most > 0.9999, "directions");
    }
  }
  options = {};
  options.size = {640, 480};
  const auto unknown = diffsac::EstimateVanishingPoints(segments, options);
  Check(unknown.focal && std::abs(unknown.focal->focal_px / 600.0 - 1.0) < 0.05, "focal length");
}

template <class Call>
void CheckThrows(const Call& call, const std::string& text) {
  try {
    call();
  } catch (const diffsac::Error& error) {
    if (std::string(error.what()).find(text) != std::string::npos) return;
    std::fprintf(stderr, "wrong: %s\n", error.what());
    std::exit(1);
  }
  Check(false, text.c_str());
}

void Mistakes() {
  Scene scene = MakeScene(false);
  diffsac::Matches few;
  few.points1 = few.points2 = Eigen::Matrix<double, 3, 2>::Ones();
  Check(diffsac::EstimateFundamental(few).status == diffsac::Status::kTooFewPoints, "too few");
  Check(diffsac::EstimateFundamental({}).status == diffsac::Status::kTooFewPoints, "none");
  CheckThrows([&] { diffsac::EstimateLine(Eigen::MatrixX2d::Zero(9, 2), {}); }, "max_distance: expected");
  diffsac::ImageOptions options;
  options.models_folder = "/none";
  CheckThrows([&] { diffsac::EstimateFundamental(scene.matches, options); },
              "model fundamental/model.safetensors: no such file; looked for /none/fundamental/model.safetensors");
  options = {};
  options.max_iterations = -1;
  CheckThrows([&] { diffsac::EstimateFundamental(scene.matches, options); }, "max_iterations: expected");
  scene.matches.similarities.setZero(200, 2);
  const auto upright = diffsac::EstimateFundamental(scene.matches);
  Check(upright.ok(), "similarities are taken");
  scene.matches.similarities.col(1).setConstant(2.0 * M_PI);
  Check(diffsac::EstimateFundamental(scene.matches).model == upright.model, "a full turn is none");
  scene.matches.similarities(3, 1) = NAN;
  CheckThrows([&] { diffsac::EstimateFundamental(scene.matches); }, "similarities: expected finite values");
  scene.matches.similarities.resize(7, 2);
  CheckThrows([&] { diffsac::EstimateFundamental(scene.matches); }, "similarities: expected one for each of 200");
  scene.matches.similarities.resize(0, 2);
  scene.matches.match_ratios.resize(7);
  CheckThrows([&] { diffsac::EstimateFundamental(scene.matches); }, "match_ratios: expected one for each of 200");
}

}  // namespace

int main() {
  TwoViews();
  Points();
  VanishingPoints();
  Mistakes();
  std::puts("all as expected");
}
