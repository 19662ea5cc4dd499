#include "diffsac/consensus/sprt.h"
#include "consensus/search.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "consensus/mock_models.h"
#include "consensus/random_problems.h"

namespace diffsac {
namespace {

using testing::MakeRandomProblem;
using testing::Place;
using testing::SearchUniformly;

TEST_CASE("The decision threshold solves its equation") {
  // A = t·C/m + 1 + log A with ε = .1, δ = .01 (Matas and Chum, section 3.1).
  const SequentialTest test(1);
  const double information = 0.99 * std::log(0.99 / 0.9) + 0.01 * std::log(0.1);
  const double a = test.decision_threshold();
  CHECK(a == Approx(100.0 * information + 1.0 + std::log(a)).epsilon(1e-6));
  CHECK(test.PassProbability() == Approx(1.0 - 1.0 / a));
  // More solutions a set make a set cheaper to lose.
  CHECK(SequentialTest(10).decision_threshold() < a);
}

TEST_CASE("The test drops models without support early and keeps good ones") {
  PointMatrix points(2000, 1);
  Rng rng(1);
  for (int i = 0; i < 2000; ++i) points(i, 0) = rng.Uniform() < 0.4 ? 0.0 : rng.Uniform(10.0, 1000.0);
  const Scorer<Place> scorer(points);
  SequentialTest test(1);
  test.AddBest(0.4);
  const auto bad = test.Test<Place>(scorer, Place::Parameters(-500.0), 0.1);
  CHECK_FALSE(bad.accepted);
  CHECK(bad.tested < 100);
  CHECK(bad.inliers == 0);
  const auto good = test.Test<Place>(scorer, Place::Parameters(0.0), 0.1);
  CHECK(good.accepted);
  CHECK(good.tested == 2000);
}

TEST_CASE("The test follows what it sees") {
  SequentialTest test(1);
  const double before = test.decision_threshold();
  CHECK_FALSE(test.AddRejected({false, 50, 5}));  // Too few points to say.
  CHECK(test.AddRejected({false, 450, 25}));      // 6 % instead of 1 %.
  CHECK(test.decision_threshold() < before);
  CHECK(test.AddBest(0.5));
  CHECK_FALSE(test.AddBest(0.3));
  CHECK_FALSE(test.AddBest(0.5));
  // Good and bad alike: nothing can be told apart, so nothing is dropped.
  CHECK(test.AddRejected({false, 100000, 60000}));
  CHECK(std::isinf(test.decision_threshold()));
  CHECK(test.PassProbability() == 1.0);
}

TEST_CASE("With the test, models are still found and most hypotheses are dropped early") {
  int recovered = 0, rejected = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const auto problem = MakeRandomProblem<3>(300, 0.6, 0.03, Rng(trial).Fork("sprt"));
    ConsensusOptions options;
    options.score = options.final_score = ScoreKind::kMsac;
    options.max_iterations = 500;
    const auto plain = SearchUniformly<Plane>(problem.points, 0.1, options, Rng(trial));
    CHECK(plain.rejected_early == 0);
    options.sprt = true;
    const auto tested = SearchUniformly<Plane>(problem.points, 0.1, options, Rng(trial));
    CHECK(tested.iterations == 500);
    rejected += tested.rejected_early;
    recovered += tested.status == Status::kOk && AngleBetweenDegrees(tested.model, problem.truth) < 1.5;
  }
  CHECK(recovered >= 97);
  CHECK(rejected > 100 * 300);
}

}  // namespace
}  // namespace diffsac
