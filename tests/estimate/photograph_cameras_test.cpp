// Fundamental matrices of photographs have cameras behind them.
#include <catch2/catch.hpp>

#include "diffsac/diffsac.h"
#include "estimate/owned_matches.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

constexpr int kSeeds = 12, kCrop = 200;

/// A motion whose F has noise enough to be far from the truth: little parallax, 80 matches, pixels.
struct Photographs {
  testing::OwnedMatches matches;
  Eigen::Matrix3d K;
  Eigen::Matrix3d essential;
};

Photographs MakePhotographs(std::uint64_t seed, int crop = 0) {
  Rng rng = Rng(70).Fork("photographs", seed);
  const double focal = rng.Uniform(800.0, 1300.0);
  Photographs made;
  made.K << focal, 0.0, 499.5 - crop, 0.0, focal, 374.5, 0.0, 0.0, 1.0;
  const RelativePose pose = testing::RandomPose(rng, 0.2);
  made.essential = EssentialFromPose(pose);
  std::vector<Eigen::Vector4d> rows;
  while (rows.size() < 80) {
    const double depth = rng.Uniform(5.0, 8.0);
    const Eigen::Vector3d first(depth * rng.Uniform(-0.4, 0.4), depth * rng.Uniform(-0.3, 0.3), depth);
    const Eigen::Vector3d second = pose.rotation * first + pose.translation;
    Eigen::Vector4d row;
    row << (made.K * first).hnormalized(), (made.K * second).hnormalized();
    for (int j = 0; j < 4; ++j) row[j] += rng.Normal();
    const auto inside = [&](double x, double y) { return x >= 0.0 && y >= 0.0 && x < 1000.0 - crop && y < 750.0; };
    if (inside(row[0], row[1]) && inside(row[2], row[3])) rows.push_back(row);
  }
  PointMatrix points(80, 4);
  for (int i = 0; i < 80; ++i) points.row(i) = rows[i].transpose();
  made.matches.points1 = points.leftCols(2);
  made.matches.points2 = points.rightCols(2);
  made.matches.size1 = made.matches.size2 = {1000 - crop, 750};
  return made;
}

ImageOptions Options(Cameras cameras) {
  ImageOptions options;
  options.guidance = Guidance::kNone;
  options.cameras = cameras;
  return options;
}

double MeanError(Cameras cameras, int crop) {
  double sum = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Photographs made = MakePhotographs(seed, crop);
    const TwoViewEstimate found = EstimateFundamental(made.matches, Options(cameras));
    if (!found.ok()) return 1e3;
    sum += testing::ModelDistance(AsParameters(made.K.transpose() * found.model * made.K).normalized(),
                                  AsParameters(made.essential).normalized());
  }
  return sum / kSeeds;
}

}  // namespace

TEST_CASE("cameras make the fundamental matrices of photographs better") {
  CHECK(MeanError(Cameras::kPhotographs, 0) < 0.8 * MeanError(Cameras::kUnknown, 0));
}

TEST_CASE("cameras make those of cropped photographs no worse") {
  CHECK(MeanError(Cameras::kPhotographs, kCrop) < 1.05 * MeanError(Cameras::kUnknown, kCrop));
}

TEST_CASE("intervals of focal lengths hold the truth") {
  int found = 0, held = 0;
  for (std::uint64_t seed = 0; seed < 4 * kSeeds; ++seed) {
    const Photographs made = MakePhotographs(seed);
    const auto focal = EstimateFundamental(made.matches, Options(Cameras::kPhotographs)).focal;
    if (!focal) continue;
    ++found;
    held += focal->low_px[0] <= made.K(0, 0) && made.K(0, 0) <= focal->high_px[0];
    CHECK(focal->focal_px[0] == focal->focal_px[1]);
  }
  CAPTURE(found, held);
  CHECK(found >= 3 * kSeeds);
  CHECK(held >= 0.6 * found);
}

TEST_CASE("without sizes nothing is known of photographs") {
  Photographs made = MakePhotographs(1);
  made.matches.size1 = {};
  const TwoViewEstimate photographs = EstimateFundamental(made.matches, Options(Cameras::kPhotographs));
  const TwoViewEstimate unknown = EstimateFundamental(made.matches, Options(Cameras::kUnknown));
  CHECK(photographs.model == unknown.model);
  CHECK(photographs.inliers == unknown.inliers);
  CHECK_FALSE(photographs.focal);
  CHECK(photographs.stats.hypotheses == unknown.stats.hypotheses);
}

TEST_CASE("images of different sizes have no common camera") {
  Photographs made = MakePhotographs(1);
  made.matches.size2 = {1100, 825};
  CHECK(EstimateFundamental(made.matches, Options(Cameras::kPhotographs)).model ==
        EstimateFundamental(made.matches, Options(Cameras::kUnknown)).model);
}

TEST_CASE("photographs in another unit give the same matrix") {
  const Photographs made = MakePhotographs(3);
  testing::OwnedMatches larger = made.matches;
  // The middle of pixels from 0 to 1999 is at 999.5. Refinement ends where a step wins a millionth.
  larger.points1 = 2.0 * larger.points1.array() + 0.5;
  larger.points2 = 2.0 * larger.points2.array() + 0.5;
  larger.size1 = larger.size2 = {2000, 1500};
  ImageOptions options = Options(Cameras::kPhotographs);
  options.max_residual = 1.0;
  const TwoViewEstimate small = EstimateFundamental(made.matches, options);
  options.max_residual = 2.0;
  const TwoViewEstimate large = EstimateFundamental(larger, options);
  REQUIRE(small.ok());
  REQUIRE(large.ok());
  Eigen::Matrix3d back;
  back << 0.5, 0.0, -0.25, 0.0, 0.5, -0.25, 0.0, 0.0, 1.0;
  const Eigen::Matrix3d expected = back.transpose() * small.model * back;
  CHECK(testing::ModelDistance(AsParameters(expected).normalized(), AsParameters(large.model).normalized()) < 1e-3);
}

}  // namespace diffsac
