#include <catch2/catch.hpp>
#include <limits>

#include "core/errors.h"
#include "diffsac/diffsac.h"
#include "diffsac/estimate/estimation_priors.h"
#include "diffsac/estimate/score_check.h"
#include "diffsac/problem/deduplicated_points.h"
#include "diffsac/problem/match_probabilities.h"
#include "diffsac/problem/tasks.h"
#include "estimate/public_functions.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::Answer;
using testing::AnswerOf;
using testing::SceneRows;

/// Matches of which `wrong` of each ten are wrong. Scores of right ones are higher, mostly, and of 1/64.
struct Scored {
  testing::OwnedMatches matches;
  testing::OwnedMatches2D3D points;
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
  input.snn_ratio = 1.0 - input.scores.array();
  input.scores = {};
  return input;
}

template <class Result>
bool SameModel(const Result& a, const Result& b) {
  return a.status == b.status && a.model == b.model && a.inliers == b.inliers;
}

TEST_CASE("Where their order alone counts, scores are 1 minus ratios, to the last digit") {
  ImageOptions options;
  options.guidance = Guidance::kNone;
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
    CHECK_FALSE(testing::MayBeChance(*estimate));
    int right = 0;
    for (std::size_t i = 0; i < estimate->inliers.size(); ++i)
      right += i % 4 != 3 && i % 10 >= 6 && estimate->inliers[i];
    CHECK(right >= 85);  // Of 90.
    CHECK(estimate->num_inliers <= right + 10);
  }
  options.models_folder = {};
  options.guidance = Guidance::kNone;
  CHECK(SameModel(EstimateFundamental(scored.matches), EstimateFundamental(scored.matches, options)));
}

TEST_CASE("Scores that all are alike, 0 and 1 too, are as good as none") {
  Scored scored = MakeScored(0, 3);
  for (const double all : {0.0, 0.5, 1.0}) {
    scored.matches.scores.setConstant(all);
    const TwoViewEstimate estimate = EstimateEssential(scored.matches, scored.cameras);
    REQUIRE(estimate.ok());
    CHECK(estimate.num_inliers >= 140);
    CHECK_FALSE(estimate.diagnostics.scores_ignored);
  }
}

/// Which rows of MakeScored are right.
bool IsRight(std::size_t row, int wrong) { return row % 4 != 3 && static_cast<int>(row % 10) >= wrong; }

/// 1 − score.
template <class Input>
Input Reversed(Input input) {
  input.scores = 1.0 - input.scores.array();
  return input;
}

/// Scores that say nothing.
template <class Input>
Input Shuffled(Input input, std::uint64_t seed) {
  Rng rng = Rng(seed).Fork("shuffled");
  for (double& score : input.scores) score = rng.Uniform(0.0, 1.0);
  return input;
}

testing::OwnedMatches3D3D MovedCloud(const Scored& scored, int wrong) {
  Rng rng(5);
  testing::OwnedMatches3D3D clouds;
  clouds.points1 = scored.points.points3d;
  clouds.points2 = clouds.points1.rowwise() + Eigen::RowVector3d(1.0, 2.0, 3.0);
  for (Eigen::Index i = 0; i < clouds.points2.rows(); ++i)
    if (!IsRight(static_cast<std::size_t>(i), wrong))
      clouds.points2.row(i) << rng.Uniform(-5.0, 5.0), rng.Uniform(-5.0, 5.0), rng.Uniform(0.0, 9.0);
  clouds.scores = scored.points.scores;
  return clouds;
}

/// What every kind of matches says. change: of scores.
std::vector<Answer> AnswersOf(const Scored& general, const Scored& flat, int wrong, auto change) {
  RegistrationOptions within;
  within.max_residual = 0.05;
  return {AnswerOf(EstimateEssential(change(general.matches), general.cameras)),
          AnswerOf(EstimateFundamental(change(general.matches))), AnswerOf(EstimateHomography(change(flat.matches))),
          AnswerOf(EstimateAbsolutePose(change(general.points), testing::kCamera)),
          AnswerOf(EstimateRigidMotion(change(MovedCloud(general, wrong)), within))};
}

void CheckRight(const Answer& answer, int wrong) {
  int right = 0, found = 0;
  for (std::size_t i = 0; i < answer.labels.size(); ++i) {
    right += IsRight(i, wrong);
    found += IsRight(i, wrong) && answer.labels[i] != 0;
  }
  CHECK(answer.is_certain());
  CHECK(found >= 0.9 * right);
}

TEST_CASE("Reversed scores and ratios cost no model and are said") {
  constexpr int kWrong = 5;
  const Scored flat = MakeScored(1, kWrong);
  for (const std::uint64_t seed : {3, 4, 5, 6}) {
    const Scored general = MakeScored(0, kWrong, seed);
    const auto reversed = [](auto input) { return Reversed(input); };
    for (const Answer& answer : AnswersOf(general, flat, kWrong, reversed)) {
      CheckRight(answer, kWrong);
      CHECK(answer.diagnostics.scores_ignored);
    }
    for (const Answer& answer :
         AnswersOf(general, flat, kWrong, [](auto input) { return AsRatios(Reversed(input)); })) {
      CheckRight(answer, kWrong);
      CHECK(answer.diagnostics.scores_ignored);
    }
    for (const Answer& answer : AnswersOf(general, flat, kWrong, [](auto input) { return input; })) {
      CheckRight(answer, kWrong);
      CHECK_FALSE(answer.diagnostics.scores_ignored);
    }
  }
}

TEST_CASE("Scores that say nothing are mostly not used") {
  constexpr int kWrong = 5;
  int ignored = 0, all = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Scored general = MakeScored(0, kWrong, seed), flat = MakeScored(1, kWrong, seed);
    for (const Answer& answer : AnswersOf(general, flat, kWrong, [&](auto input) { return Shuffled(input, seed); })) {
      CheckRight(answer, kWrong);
      ignored += answer.diagnostics.scores_ignored;
      ++all;
    }
  }
  CHECK(ignored >= 0.8 * all);
}

TEST_CASE("A search without scores needs no network and repeats itself") {
  Scored scored = MakeScored(0, 5);
  scored.matches = Reversed(scored.matches);
  ImageOptions options;
  options.models_folder = "/none";
  const TwoViewEstimate without_network = EstimateEssential(scored.matches, scored.cameras, options);
  CheckRight(AnswerOf(without_network), 5);
  CHECK(without_network.diagnostics.scores_ignored);
  const TwoViewEstimate once = EstimateEssential(scored.matches, scored.cameras);
  CHECK(SameModel(once, EstimateEssential(scored.matches, scored.cameras)));
  testing::OwnedMatches none = scored.matches;
  none.scores = {};
  const TwoViewEstimate of_none = EstimateEssential(none, scored.cameras);
  CHECK(SameModel(once, of_none));
  CHECK(once.posteriors == of_none.posteriors);
  CHECK(once.stats.iterations > of_none.stats.iterations);
}

/// An estimate of `count` rows that chance does not give. Every third row is an inlier.
Estimate EveryThird(Eigen::Index count) {
  Estimate estimate;
  estimate.status = Status::kOk;
  estimate.log10_nfa = -50.0;
  for (Eigen::Index i = 0; i < count; ++i) estimate.inliers.push_back(i % 3 == 0);
  return estimate;
}

TEST_CASE("Scores are doubted by their order alone and by sure estimates only against it") {
  Problem problem;
  problem.task = Task::kFundamental;
  problem.points = SceneRows(150, 0, 1).rightCols(4);
  Rng rng(2);
  problem.snn_ratio.resize(150);
  for (Eigen::Index i = 0; i < 150; ++i) problem.snn_ratio[i] = 0.1 + rng.Uniform(0.0, i % 3 == 0 ? 0.5 : 0.8);
  Estimate estimate = EveryThird(150);
  CHECK_FALSE(DoubtsScores(problem, estimate));
  Problem other = problem;
  const auto doubts = [&](const Eigen::VectorXd& ratios) {
    other.snn_ratio = ratios;
    return DoubtsScores(other, estimate);
  };
  CHECK_FALSE(doubts(problem.snn_ratio.array().cube()));
  CHECK(doubts(1.0 - problem.snn_ratio.array()));
  CHECK(doubts(1.0 - problem.snn_ratio.array().cube()));
  testing::OwnedMatches shuffled;
  shuffled.scores = problem.snn_ratio;
  CHECK(doubts(Shuffled(shuffled, 7).scores));
  CHECK_FALSE(doubts({}));
  // A row that is not finite may have any ratio.
  other.points(1, 0) = std::numeric_limits<double>::infinity();
  Eigen::VectorXd with_nan = problem.snn_ratio;
  with_nan[1] = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(doubts(with_nan));
  estimate.log10_nfa = 1.0;
  CHECK(doubts(problem.snn_ratio));
  CHECK_FALSE(doubts(Eigen::VectorXd::Constant(150, 0.5)));
  estimate.status = Status::kDegenerate;
  CHECK_FALSE(doubts(problem.snn_ratio));
}

TEST_CASE("An estimate without scores is taken by its support") {
  Problem problem;
  problem.task = Task::kFundamental;
  problem.points = SceneRows(150, 0, 1).rightCols(4);
  problem.snn_ratio = Eigen::VectorXd::LinSpaced(150, 0.0, 1.0);
  Eigen::VectorXd reversed(150);
  for (Eigen::Index i = 0; i < 150; ++i) reversed[i] = i % 3 == 0 ? 0.9 : 0.1 + 0.001 * static_cast<double>(i);
  const auto taken = [&](double with, double without) {
    Estimate estimate = EveryThird(150), other = EveryThird(150);
    estimate.log10_nfa = with;
    other.log10_nfa = without;
    return IsBetterWithoutScores(problem, other, estimate);
  };
  problem.snn_ratio = 1.0 - reversed.array();
  CHECK_FALSE(taken(-50.0, -50.0));
  CHECK(taken(-50.0, -70.0));
  CHECK_FALSE(taken(-5.0, -10.0));
  CHECK(taken(3.0, -70.0));
  CHECK_FALSE(taken(3.0, -5.0));
  CHECK_FALSE(taken(3.0, 2.0));
  problem.snn_ratio = reversed;
  CHECK(taken(-50.0, -50.0));
  CHECK(taken(3.0, -5.0));
  CHECK_FALSE(taken(-50.0, -10.0));
  CHECK_FALSE(taken(3.0, 2.0));
}

TEST_CASE("trouble: scores that are none, of another number, or beside ratios") {
  const Scored scored = MakeScored(0, 3);
  const auto error = [&](auto change) {
    testing::OwnedMatches matches = scored.matches;
    testing::OwnedMatches2D3D points = scored.points;
    change(&matches), change(&points);
    const std::string first = ErrorOf([&] { EstimateFundamental(matches); });
    CHECK(first == ErrorOf([&] { EstimateAbsolutePose(points, testing::kCamera); }));
    CHECK(first == ErrorOf([&] { EstimateMultipleFundamentals(matches); }));
    CHECK(first == ErrorOf([&] { EstimateSharedFocal(matches); }));
    return first;
  };
  for (const double wrong : {-0.1, 1.01, 20.0, std::numeric_limits<double>::quiet_NaN()}) {
    const std::string text = error([&](auto* input) { input->scores[17] = wrong; });
    CHECK(text.rfind("scores: expected a matcher's confidences, from 0 to 1, higher is better, got", 0) == 0);
    CHECK(Has(text, "in row 17"));
  }
  CHECK(error([](auto* input) { input->scores[17] = 1.0 + 1e-7; }).empty());  // Of single precision.
  CHECK(Has(error([](auto* input) { input->scores.conservativeResize(5); }), "scores: expected one for each of 300"));
  CHECK(Has(error([](auto* input) { input->snn_ratio = input->scores; }), "scores: expected none beside snn_ratio"));
}

TEST_CASE("Of equal matches the one of the best score counts") {
  const Scored scored = MakeScored(0, 3);
  testing::OwnedMatches twice = scored.matches;
  const Eigen::Index count = twice.points1.rows();
  twice.points1 = scored.matches.points1.replicate(2, 1);
  twice.points2 = scored.matches.points2.replicate(2, 1);
  twice.scores.resize(2 * count);
  twice.scores << scored.matches.scores, 0.5 * scored.matches.scores;
  const TwoViewEstimate estimate = EstimateEssential(twice, scored.cameras);
  CHECK(estimate.diagnostics.num_duplicates == count);
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
  options.guidance = Guidance::kNone;
  int flagged = 0, of_no_scores = 0;
  constexpr int kTrials = 10;
  for (int trial = 0; trial < kTrials; ++trial) {
    Rng rng(trial);
    const PointMatrix wrong = WrongGroups(rng);
    const testing::TwoViewProblem pair = testing::RandomProblem(100, rng, 2.0);
    PointMatrix mixed(244, 4);
    mixed << pair.pixels, wrong;
    const auto unscored = [](const PointMatrix& points) {
      testing::OwnedMatches matches = testing::MatchesOf(points, {});
      matches.size1 = matches.size2 = {};
      return matches;
    };
    const auto give = [&](const PointMatrix& points) {
      testing::OwnedMatches matches = unscored(points);
      matches.scores = Eigen::VectorXd::Constant(points.rows(), 0.5);
      return matches;
    };
    const CameraPair cameras{pair.k1, pair.k2};
    CHECK_FALSE(testing::MayBeChance(EstimateEssential(give(mixed), cameras, options)));
    CHECK_FALSE(testing::MayBeChance(EstimateFundamental(give(mixed), options)));
    flagged += testing::MayBeChance(EstimateEssential(give(wrong), cameras, options)) +
               testing::MayBeChance(EstimateFundamental(give(wrong), options));
    of_no_scores += testing::MayBeChance(EstimateEssential(unscored(wrong), cameras, options)) +
                    testing::MayBeChance(EstimateFundamental(unscored(wrong), options));
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
  problem.snn_ratio = 1.0 - Eigen::ArrayXd::LinSpaced(20, 0.0, 1.0);
  const Eigen::VectorXd priors = MatchPriors(problem);
  CHECK(priors[0] == Approx(0.05));
  CHECK(priors[19] == Approx(0.95));
  CHECK((priors.tail(19) - priors.head(19)).minCoeff() > 0.0);
  const Problem part = PartOf(problem, {3, 19});
  CHECK(MatchPriors(part) == Eigen::Vector2d(priors[3], priors[19]));
}

}  // namespace
}  // namespace diffsac
