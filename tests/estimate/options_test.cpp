// The options, verdicts and older names of diffsac/diffsac.h.
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/errors.h"
#include "diffsac/diffsac.h"
#include "estimate/owned_matches.h"
#include "geometry/cloud_scene.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

/// Calibrated views, of which `wrong` of 300 matches are wrong.
struct Views {
  testing::OwnedMatches matches;
  CameraPair cameras;
  RelativePose pose;

  explicit Views(int wrong, std::uint64_t seed = 1) {
    Rng rng(seed);
    const testing::TwoViewProblem random = testing::RandomProblem(300, rng, 0.5);
    matches.points1 = random.pixels.leftCols(2);
    matches.points2 = random.pixels.rightCols(2);
    for (int i = 0; i < wrong; ++i) matches.points2.row(i) << rng.Uniform(0.0, 1000.0), rng.Uniform(0.0, 800.0);
    cameras = {random.k1, random.k2};
    pose = random.pose;
  }
};

TwoViewEstimate Find(const Views& views, const ImageOptions& options) {
  return EstimateEssential(views.matches, views.cameras, options);
}

TEST_CASE("options bound samples and threads change nothing") {
  const Views views(210);
  const auto draws = [&](const ImageOptions& options) { return Find(views, options).stats.iterations; };
  for (const Guidance guidance : {Guidance::kNetwork, Guidance::kNone}) {
    CHECK(draws({.max_iterations = 40, .guidance = guidance}) <= 40);
    CHECK(draws({.min_iterations = 700, .guidance = guidance}) >= 700);
    CHECK(draws({.min_iterations = 1500, .guidance = guidance}) >= 1500);
    CHECK(draws({.min_iterations = 0, .confidence = 0.5, .guidance = guidance}) <
          draws({.min_iterations = 0, .confidence = 1.0 - 1e-8, .guidance = guidance}));
    const TwoViewEstimate one = Find(views, {.guidance = guidance, .seed = 3});
    for (const int threads : {0, 3})
      CHECK(Find(views, {.num_threads = threads, .guidance = guidance, .seed = 3}).model == one.model);
  }
}

TEST_CASE("an initial model is found where samples fail") {
  const Views views(270);  // A sample of right matches alone is one of 100000.
  const Eigen::Matrix3d truth = EssentialFromPose(views.pose);
  const ImageOptions few{.max_iterations = 1, .guidance = Guidance::kNone};
  ImageOptions given = few;
  given.initial_model = 7.0 * truth;
  const auto found = Find(views, given);
  REQUIRE(found.pose);
  CHECK(RotationAngleDegrees(found.pose->rotation, views.pose.rotation) < 1.0);
  CHECK(found.num_inliers > 27);
  CHECK(Find(views, few).num_inliers < found.num_inliers);
  given.guidance = Guidance::kNetwork;
  CHECK(Find(views, given).num_inliers > 27);
  given.initial_model = Eigen::MatrixXd::Identity(3, 4);
  CHECK(Has(ErrorOf([&] { Find(views, given); }), "initial_model: expected 3 x 3"));
}

TEST_CASE("initial motions are in the given frame") {
  for (const double scale : {1.0, 1e6}) {
    const auto scene = testing::MakeCloudScene(400, 0.98, 0.001, Rng(5));
    testing::OwnedMatches3D3D matches{scale * scene.points.leftCols(3), scale * scene.points.rightCols(3)};
    matches.points2.rowwise() += Eigen::RowVector3d(3e5, -2e5, 1e4) * scale;
    Eigen::MatrixXd truth(3, 4);
    truth << RotationOf(scene.truth), scale * (TranslationOf(scene.truth) + Eigen::Vector3d(3e5, -2e5, 1e4));
    RegistrationOptions options{.max_residual = 0.005 * scale, .max_iterations = 1};
    CHECK(EstimateRigidMotion(matches, options).num_inliers < 8);
    options.initial_model = truth;
    CHECK(EstimateRigidMotion(matches, options).num_inliers == 8);
    CHECK(EstimateSimilarity(matches, options).num_inliers == 8);
  }
}

TEST_CASE("options out of range name the field") {
  const Views views(0);
  const auto refused = [&](const ImageOptions& options, const std::string& field) {
    CHECK_THROWS_AS(Find(views, options), std::invalid_argument);
    CHECK_THROWS_AS(Find(views, options), std::exception);
    CHECK(ErrorOf([&] { Find(views, options); }).starts_with(field + ": expected"));
  };
  refused({.max_residual = 0.0}, "max_residual");
  refused({.max_iterations = 0}, "max_iterations");
  refused({.min_iterations = -1}, "min_iterations");
  refused({.max_iterations = 10, .min_iterations = 20}, "min_iterations");
  refused({.confidence = 1.0}, "confidence");
  refused({.confidence = std::nan("")}, "confidence");
  refused({.num_threads = -1}, "num_threads");
  CHECK(ErrorOf([&] { EstimateLine(views.matches.points1, {}); }).starts_with("max_residual: expected"));
}

TEST_CASE("verdicts say whether a result may be used") {
  CHECK(Find(Views(100), {}).verdict == Verdict::kReliable);
  CHECK(Find(Views(100), {}).reliable());
  CHECK(Find(Views(300), {}).verdict <= Verdict::kUnreliable);
  CHECK(EstimateFundamental({}).verdict == Verdict::kFailed);
  Views still(0);
  still.matches.points2 = still.matches.points1;
  still.cameras.K2 = still.cameras.K1;
  const auto unmoved = Find(still, {});
  CHECK(unmoved.verdict == (unmoved.ok() ? Verdict::kRotationOnly : Verdict::kFailed));
  CHECK(unmoved.diagnostics.degeneracy == Degeneracy::kStatic);
}

TEST_CASE("vectors of points are taken as matrices are") {
  const Views views(60);
  std::vector<Eigen::Vector2d> first, second;
  for (Eigen::Index i = 0; i < 300; ++i) {
    first.emplace_back(views.matches.points1.row(i));
    second.emplace_back(views.matches.points2.row(i));
  }
  CHECK(EstimateFundamental({.points1 = first, .points2 = second}).model == EstimateFundamental(views.matches).model);
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
TEST_CASE("names of the last version still compile") {
  const Eigen::MatrixXd points = Eigen::MatrixXd::Random(40, 2);
  const PointOptions options{.max_residual = 0.01};
  const ModelsEstimate<Eigen::Vector3d> lines = EstimateLines(points, options);
  CHECK(lines.status == EstimateMultipleLines(points, options).status);
  const CloudOptions cloud{.max_residual = 0.1};
  CHECK(EstimateRigidMotions(CloudMatches(), cloud).status == Status::kTooFewPoints);
  CHECK(ScenePoints().points3d.empty());
}
#pragma GCC diagnostic pop

}  // namespace
}  // namespace diffsac
