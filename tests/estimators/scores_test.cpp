#include <catch2/catch.hpp>
#include <limits>

#include "core/errors.h"
#include "diffsac/diffsac.h"
#include "diffsac/estimators/estimation_priors.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/problem/usable_rows.h"
#include "estimators/public_functions.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::SceneRows;

/// Matches of which `wrong` of each ten are wrong. Scores of right ones are higher, mostly, and of 1/64.
struct Scored {
  Matches matches;
  ScenePoints points;
  CameraPair cameras{testing::kCamera, testing::kCamera};
};

Scored MakeScored(int planes, int wrong, std::uint64_t seed = 3) {
  PointMatrix rows = SceneRows(300, planes, seed);
  Rng rng = Rng(seed).Fork("scores");
  Eigen::VectorXd scores(rows.rows());
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const bool is_wrong = i % 4 == 3 || static_cast<int>(i % 10) < wrong;
    if (is_wrong) rows.row(i).tail<2>() << rng.Uniform(0.0, 640.0), rng.Uniform(0.0, 480.0);
    scores[i] = static_cast<double>(rng.Below(is_wrong ? 40 : 64)) / 64.0;
  }
  Scored made;
  made.matches = testing::MatchesOf(rows.rightCols(4), {});
  made.points = {rows.leftCols(3), rows.rightCols(2)};
  made.matches.scores = made.points.scores = scores;
  return made;
}

template <class Input>
Input AsRatios(Input input) {
  input.match_ratios = 1.0 - input.scores.array();
  input.scores = {};
  return input;
}

template <class Result>
bool SameModel(const Result& a, const Result& b) {
  return a.status == b.status && a.model == b.model && a.inliers == b.inliers;
}

TEST_CASE("Where their order alone counts, scores are 1 minus ratios, to the last digit") {
  ImageOptions options;
  options.use_network = false;
  const Scored flat = MakeScored(1, 3), general = MakeScored(0, 3);
  CHECK(SameModel(EstimateHomography(flat.matches, options), EstimateHomography(AsRatios(flat.matches), options)));
  CHECK(SameModel(EstimateAbsolutePose(general.points, testing::kCamera),
                  EstimateAbsolutePose(AsRatios(general.points), testing::kCamera)));
}

TEST_CASE("With scores no network is asked for, nor needed, and what few matches are right are found") {
  const Scored scored = MakeScored(0, 6);
  ImageOptions options;
  options.models_folder = "/none";
  CHECK(Has(ErrorOf([&] { EstimateFundamental(AsRatios(scored.matches), options); }), "/none"));
  const TwoViewEstimate fundamental = EstimateFundamental(scored.matches, options),
                        essential = EstimateEssential(scored.matches, scored.cameras, options);
  for (const TwoViewEstimate* estimate : {&fundamental, &essential}) {
    REQUIRE(estimate->ok());
    CHECK_FALSE(estimate->may_be_chance());
    int right = 0;
    for (std::size_t i = 0; i < estimate->inliers.size(); ++i)
      right += i % 4 != 3 && i % 10 >= 6 && estimate->inliers[i];
    CHECK(right >= 85);  // Of 90.
    CHECK(estimate->num_inliers <= right + 10);
  }
  options.models_folder = {};
  options.use_network = false;
  CHECK(SameModel(EstimateFundamental(scored.matches), EstimateFundamental(scored.matches, options)));
}

TEST_CASE("Scores that all are alike, 0 and 1 too, are as good as none") {
  Scored scored = MakeScored(0, 3);
  for (const double all : {0.0, 0.5, 1.0}) {
    scored.matches.scores.setConstant(all);
    const TwoViewEstimate estimate = EstimateEssential(scored.matches, scored.cameras);
    REQUIRE(estimate.ok());
    CHECK(estimate.num_inliers >= 140);
  }
}

TEST_CASE("trouble: scores that are none, of another number, or beside ratios") {
  const Scored scored = MakeScored(0, 3);
  const auto error = [&](auto change) {
    Matches matches = scored.matches;
    ScenePoints points = scored.points;
    change(&matches), change(&points);
    const std::string first = ErrorOf([&] { EstimateFundamental(matches); });
    CHECK(first == ErrorOf([&] { EstimateAbsolutePose(points, testing::kCamera); }));
    CHECK(first == ErrorOf([&] { EstimateFundamentals(matches); }));
    CHECK(first == ErrorOf([&] { EstimateSharedFocal(matches); }));
    return first;
  };
  for (const double wrong : {-0.1, 1.01, 20.0, std::numeric_limits<double>::quiet_NaN()}) {
    const std::string text = error([&](auto* input) { input->scores[17] = wrong; });
    CHECK(text.rfind("scores: expected what a matcher says, from 0 to 1, higher is better, got", 0) == 0);
    CHECK(Has(text, "in row 17"));
  }
  CHECK(error([](auto* input) { input->scores[17] = 1.0 + 1e-7; }).empty());  // Of single precision.
  CHECK(Has(error([](auto* input) { input->scores.conservativeResize(5); }), "scores: expected one for each of 300"));
  CHECK(Has(error([](auto* input) { input->match_ratios = input->scores; }),
            "scores: expected none beside match_ratios"));
}

TEST_CASE("Of equal matches the one of the best score counts") {
  const Scored scored = MakeScored(0, 3);
  Matches twice = scored.matches;
  const Eigen::Index count = twice.points1.rows();
  twice.points1 = scored.matches.points1.replicate(2, 1);
  twice.points2 = scored.matches.points2.replicate(2, 1);
  twice.scores.resize(2 * count);
  twice.scores << scored.matches.scores, 0.5 * scored.matches.scores;
  const TwoViewEstimate estimate = EstimateEssential(twice, scored.cameras);
  CHECK(estimate.repeated_rows == count);
  CHECK(estimate.model == EstimateEssential(scored.matches, scored.cameras).model);
}

/// 12 groups of 12 matches, each from one place to another that have nothing in common: as matchers that look at all
/// keypoints together are wrong.
PointMatrix WrongGroups(Rng& rng) {
  PointMatrix points(144, 4);
  Eigen::Vector4d place;
  for (int i = 0; i < 144; ++i) {
    if (i % 12 == 0) place << rng.Uniform(0, 1000), rng.Uniform(0, 800), rng.Uniform(0, 1000), rng.Uniform(0, 800);
    const Eigen::Vector2d within(rng.Uniform(-40, 40), rng.Uniform(-40, 40));
    for (int j = 0; j < 4; ++j) points(i, j) = place[j] + within[j % 2] + 4.0 * rng.Normal();
  }
  return points;
}

TEST_CASE(
    "Matches with scores may be chance where wrong ones agree with each other, and are not beside noisy right ones") {
  ImageOptions options;
  options.use_network = false;
  int flagged = 0, of_no_scores = 0;
  constexpr int kTrials = 10;
  for (int trial = 0; trial < kTrials; ++trial) {
    Rng rng(trial);
    const PointMatrix wrong = WrongGroups(rng);
    const testing::TwoViewProblem pair = testing::RandomProblem(100, rng, 2.0);
    PointMatrix mixed(244, 4);
    mixed << pair.pixels, wrong;
    const auto give = [](const PointMatrix& points) {
      Matches matches = testing::MatchesOf(points, {});
      matches.scores = Eigen::VectorXd::Constant(points.rows(), 0.5);
      return matches;
    };
    const CameraPair cameras{pair.k1, pair.k2};
    CHECK_FALSE(EstimateEssential(give(mixed), cameras, options).may_be_chance());
    CHECK_FALSE(EstimateFundamental(give(mixed), options).may_be_chance());
    flagged += EstimateEssential(give(wrong), cameras, options).may_be_chance() +
               EstimateFundamental(give(wrong), options).may_be_chance();
    of_no_scores += EstimateEssential(testing::MatchesOf(wrong, {}), cameras, options).may_be_chance() +
                    EstimateFundamental(testing::MatchesOf(wrong, {}), options).may_be_chance();
  }
  CAPTURE(flagged, of_no_scores);
  CHECK(flagged >= 0.9 * 2 * kTrials);
  CHECK(of_no_scores < flagged);
}

TEST_CASE("A score is a probability that is never 0 or 1, and stays with its row") {
  Problem problem;
  problem.task = Task::kFundamental;
  problem.points = SceneRows(20, 0, 1).rightCols(4);
  CHECK(MatchPriors(problem).size() == 0);
  problem.scored = true;
  problem.match_ratio = 1.0 - Eigen::ArrayXd::LinSpaced(20, 0.0, 1.0);
  const Eigen::VectorXd priors = MatchPriors(problem);
  CHECK(priors[0] == Approx(0.05));
  CHECK(priors[19] == Approx(0.95));
  CHECK((priors.tail(19) - priors.head(19)).minCoeff() > 0.0);
  const Problem part = PartOf(problem, {3, 19});
  CHECK(MatchPriors(part) == Eigen::Vector2d(priors[3], priors[19]));
}

}  // namespace
}  // namespace diffsac
