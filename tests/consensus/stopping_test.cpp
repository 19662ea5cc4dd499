#include "diffsac/consensus/stopping.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

std::int64_t Draws(std::int64_t inliers, std::int64_t points, double confidence, double multiplier = 1.0) {
  return DrawsForConfidence(AllInlierProbability(inliers, points, 3), confidence, multiplier);
}

TEST_CASE("Golden numbers of draws for sets of three") {
  CHECK(Draws(10, 100, 0.99) == 6204);
  CHECK(Draws(10, 100, 0.999) == 9305);
  CHECK(Draws(10, 100, 0.999, 2.0) == 18610);
  CHECK(Draws(50, 100, 0.99) == 36);
  CHECK(Draws(50, 100, 0.999) == 54);
  CHECK(Draws(100, 100, 0.99) == 1);
  CHECK(Draws(100, 100, 0.999999) == 1);
  CHECK(Draws(1, 100, 0.99) == kNeverEnough);
}

TEST_CASE("The probability is hypergeometric") {
  CHECK(AllInlierProbability(5, 10, 5) == Approx(1.0 / 252.0).epsilon(1e-12));
  CHECK(AllInlierProbability(5, 10, 5) < 0.2 * std::pow(0.5, 5));  // with replacement it would be 1/32
  CHECK(AllInlierProbability(5, 10, 0) == 1.0);
  CHECK(AllInlierProbability(4, 10, 5) == 0.0);
  CHECK(AllInlierProbability(0, 0, 2) == 0.0);
  CHECK(AllInlierProbability(10, 10, 7) == 1.0);
  // As it is drawn.
  Rng rng(1);
  int good = 0, set[3];
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) {
    rng.Distinct(8, 3, set);
    good += set[0] < 5 && set[1] < 5 && set[2] < 5;
  }
  CHECK(static_cast<double>(good) / kDraws == Approx(AllInlierProbability(5, 8, 3)).margin(0.005));
}

TEST_CASE("Draws at the ends of the ranges") {
  CHECK(DrawsForConfidence(0.5, 0.0) == 1);
  CHECK(DrawsForConfidence(0.5, 1.0) == kNeverEnough);
  CHECK(DrawsForConfidence(1.0, 1.0) == 1);
  CHECK(DrawsForConfidence(0.0, 0.5) == kNeverEnough);
  CHECK(DrawsForConfidence(std::nan(""), 0.5) == kNeverEnough);
  CHECK(DrawsForConfidence(1e-300, 0.99) == kNeverEnough);
  CHECK(DrawsForConfidence(1e-17, 0.99) == Approx(4.605170186e17));
}

TEST_CASE("Names of reasons") {
  CHECK(ToString(StopReason::kNotRun) == "not_run");
  CHECK(ToString(StopReason::kBudget) == "budget");
  CHECK(ToString(StopReason::kConfidence) == "confidence");
  CHECK(ToString(StopReason::kExhausted) == "exhausted");
}

}  // namespace
}  // namespace diffsac
