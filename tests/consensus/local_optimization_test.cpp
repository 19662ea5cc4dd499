#include "diffsac/consensus/local/local_optimizer.h"

#include <catch2/catch.hpp>

#include "diffsac/geometry/fundamental.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

TEST_CASE("Few points are all looked at, many in part, enough inliers always") {
  CHECK(PartSize(100, 50) == 100);
  CHECK(PartSize(999, 900) == 999);
  CHECK(PartSize(1000, 500) == kPartPoints);
  CHECK(PartSize(1000, 250) == 1000);
  for (const int size : {1000, 5000, 100000})
    for (const int inliers : {10, 100, 1000}) {
      const int part = PartSize(size, inliers);
      CHECK(part <= size);
      if (part < size) CHECK(static_cast<double>(part) * inliers / size >= kPartInliers);
    }
}

TEST_CASE("Inner samples of a part improve a model as those of all points do") {
  constexpr double kThreshold = 1.5;
  Rng rng(1);
  double start_sum = 0.0, part_sum = 0.0, all_sum = 0.0;
  for (int trial = 0; trial < 10; ++trial) {
    auto problem = testing::RandomProblem(3000, rng, 0.5);
    for (int i = 0; i < 1500; ++i) problem.pixels(i, 2) += 200.0 * rng.Normal();
    const Scorer<Fundamental> scorer(problem.pixels);
    const Score score(ScoreKind::kMsac, kThreshold, 0.5, 20.0);
    int set[7], fits = 0;
    ScoredModel<Fundamental> start{Matrix3Parameters::Zero(), -1.0};
    for (int draw = 0; draw < 5; ++draw) {
      for (int i = 0; i < 7; ++i) set[i] = 1500 + 200 * i + draw;
      Matrix3Parameters models[3];
      const int count = Fundamental::SolveMinimal(problem.pixels, set, models);
      for (int i = 0; i < count; ++i)
        if (scorer(models[i], score) > start.score) start = {models[i], scorer(models[i], score)};
    }
    REQUIRE(start.score > 0.0);
    const auto part = OptimizeByInnerSamples<Fundamental>(scorer, score, kThreshold, 10, start, Rng(trial), &fits);
    const auto all = FitInnerSamples<Fundamental>(scorer, score, kThreshold, 10, start, Rng(trial), &fits);
    CHECK(part.score == scorer(part.model, score));
    CHECK(part.score >= start.score);
    start_sum += start.score;
    part_sum += part.score;
    all_sum += all.score;
  }
  CHECK(part_sum > start_sum);
  CHECK(part_sum > 0.99 * all_sum);
}

}  // namespace
}  // namespace diffsac
