// Stopping by what the source itself knows of its draws.

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "consensus/random_problems.h"
#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/consensus/stopping.h"
#include "diffsac/consensus/weighted_sampler.h"

namespace diffsac {
namespace {

constexpr int kPoints = 40, kInliers = 12, kSize = 3;

std::vector<std::uint8_t> Mask() {
  std::vector<std::uint8_t> mask(kPoints, 0);
  std::fill(mask.begin(), mask.begin() + kInliers, 1);
  return mask;
}

/// The share of the source's draws that hold inliers alone.
double MeasuredShare(MinimalSampler& source, const std::vector<std::uint8_t>& mask) {
  constexpr int kDraws = 200000;
  int good = 0, set[kSize];
  for (int i = 0; i < kDraws; ++i) {
    REQUIRE(source.Next(set));
    good += mask[set[0]] && mask[set[1]] && mask[set[2]];
  }
  return static_cast<double>(good) / kDraws;
}

}  // namespace

TEST_CASE("a source that knows nothing of its draws takes them for uniform ones") {
  const auto mask = Mask();
  const InlierSets sets{mask, kInliers, kSize};
  const UniformSampler source(kPoints, kSize, Rng(1));
  CHECK(source.LogMissed(sets) == Approx(std::log1p(-AllInlierProbability(kInliers, kPoints, kSize))));
  CHECK(source.DrawsUntil(sets, std::log(0.01)) ==
        DrawsForConfidence(AllInlierProbability(kInliers, kPoints, kSize), 0.99));
  const std::vector<std::uint8_t> none(kPoints, 0);
  CHECK(source.DrawsUntil({none, 0, kSize}, std::log(0.01)) == kNeverEnough);
}

TEST_CASE("weighted draws are of inliers alone as often as their source says") {
  const auto mask = Mask();
  Rng rng(2);
  for (const double favour : {1.0, 3.0, 20.0}) {
    std::vector<double> weights;
    for (int i = 0; i < kPoints; ++i) weights.push_back((mask[i] ? favour : 1.0) * (0.5 + rng.Uniform()));
    WeightedSampler source(weights, kSize, Rng(3));
    const double said = -std::expm1(source.LogMissed({mask, kInliers, kSize}));
    CHECK(said == Approx(MeasuredShare(source, mask)).epsilon(0.05).margin(0.002));
    CHECK(-std::expm1(source.LogMissed({mask, kInliers, kSize, 0.5})) == Approx(0.5 * said));
  }
}

TEST_CASE("a sequence counts the draws of its parts, each with its own probability") {
  const auto mask = Mask();
  const InlierSets sets{mask, kInliers, kSize};
  std::vector<double> good(kPoints, 1.0);
  for (int i = 0; i < kInliers; ++i) good[i] = 30.0;
  const double uniform = UniformSampler(kPoints, kSize, Rng(1)).LogMissed(sets);
  const double guided = WeightedSampler(good, kSize, Rng(1)).LogMissed(sets);
  SequenceSampler sequence;
  sequence.Add(std::make_unique<UniformSampler>(kPoints, kSize, Rng(1)), 10);
  sequence.Add(std::make_unique<WeightedSampler>(good, kSize, Rng(1)));
  const double target = std::log(1e-4);
  CHECK(sequence.DrawsUntil(sets, target) ==
        10 + static_cast<std::int64_t>(std::ceil((target - 10 * uniform) / guided)));
  CHECK(sequence.DrawsUntil(sets, 5.0 * uniform) == 5);
  int set[kSize];
  for (int i = 0; i < 12; ++i) REQUIRE(sequence.Next(set));
  CHECK(sequence.DrawsUntil(sets, 5.0 * uniform) == 5);
}

TEST_CASE("a guided search ends sooner with a good guide, and not before min_iterations") {
  Rng rng(4);
  PointMatrix points(200, 2);
  std::vector<double> weights(200, 1.0);
  for (int i = 0; i < 200; ++i) {
    const double x = rng.Uniform(0.0, 10.0);
    points.row(i) << x, i < 40 ? 0.5 * x + 1.0 + 0.01 * rng.Normal() : rng.Uniform(0.0, 10.0);
    if (i < 40) weights[i] = 30.0;
  }
  const auto draws = [&](Stopping stopping, int least) {
    ConsensusOptions options;
    options.stopping = stopping;
    options.max_iterations = 5000;
    options.min_iterations = least;
    options.confidence = 0.9999;
    WeightedSampler source(weights, 2, Rng(5));
    const auto result = SampleConsensus<Line>(points, 0.05, source, options, Rng(6));
    CHECK(result.status == Status::kOk);
    CHECK(result.stop == StopReason::kConfidence);
    return result.iterations;
  };
  CHECK(draws(Stopping::kGuided, 0) < 30);
  CHECK(draws(Stopping::kConfidence, 0) > 150);
  CHECK(draws(Stopping::kGuided, 100) == 100);
}

}  // namespace diffsac
