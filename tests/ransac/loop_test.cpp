// The loop on mock models: what it counts, when it stops, which model it keeps.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "diffsac/core/random.h"
#include "diffsac/ransac/consensus_options.h"
#include "diffsac/ransac/option_names.h"
#include "diffsac/ransac/sample_consensus_impl.h"
#include "ransac/all_models.h"
#include "ransac/random_problems.h"

namespace diffsac {
namespace {

using testing::SearchExhaustively;
using testing::SearchSets;
using testing::SearchUniformly;

/// A number on a line, from one point: the simplest model there is.
struct Place {
  using Parameters = Eigen::Matrix<double, 1, 1>;
  static constexpr int kDimension = 1;
  static constexpr int kMinimalSize = 1;
  static constexpr int kMaxSolutions = 1;
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
    (*out)[0] = points(set[0], 0);
    return 1;
  }
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
    const double total = weights.sum();
    if (!(total > 0.0)) return false;
    (*out)[0] = points.col(0).dot(weights) / total;
    return true;
  }
  static double Residual(const Parameters& model, const double* point) { return std::abs(model[0] - point[0]); }
};

/// From two points, with ten solutions of which the last is their mean: no solution where they are equal.
struct TenPlaces : Place {
  static constexpr int kMinimalSize = 2;
  static constexpr int kMaxSolutions = 10;
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
    const double a = points(set[0], 0), b = points(set[1], 0);
    if (a == b) return 0;
    for (int i = 0; i < 9; ++i) out[i][0] = 1e6 + i;
    out[9][0] = 0.5 * (a + b);
    return 10;
  }
};

/// Never near any point.
struct FarPlace : Place {
  static int SolveMinimal(const PointMatrix&, const int*, Parameters* out) {
    (*out)[0] = 1e9;
    return 1;
  }
};

enum class RefineMode { kToMean, kAway, kNaN, kRefuse };

/// A place with a refinement that does as it is told.
template <RefineMode kMode>
struct RefinedPlace : Place {
  static bool Refine(const PointMatrix& points, double threshold, Parameters* model) {
    if (kMode == RefineMode::kAway) (*model)[0] += 100.0 * threshold;
    if (kMode == RefineMode::kNaN) (*model)[0] = std::numeric_limits<double>::quiet_NaN();
    if (kMode != RefineMode::kToMean) return kMode != RefineMode::kRefuse;
    const Eigen::VectorXd near = ((points.col(0).array() - (*model)[0]).abs() <= threshold).template cast<double>();
    return Fit(points, near, model);
  }
};

/// A place that is degenerate when it comes from an even point: then its hook offers 5 and a bad one, for three fits.
/// What is not from a set is degenerate at 20 exactly, and mended to 30.
struct MendedPlace : Place {
  static constexpr int kMaxSolutions = 2;
  static int RecoverFromDegeneracy(const PointMatrix&, const int* set, const Parameters& model, double, Rng,
                                   Parameters* out, int* fits) {
    out[0][0] = -1e6;
    out[1][0] = set == nullptr ? 30.0 : 5.0;
    if (set == nullptr ? model[0] != 20.0 : set[0] % 2 != 0) return 0;
    *fits += 3;
    return 2;
  }
};

/// From two points, one solution.
struct Pair : TenPlaces {
  static constexpr int kMaxSolutions = 1;
  static int SolveMinimal(const PointMatrix& all, const int* set, Parameters* out) {
    (*out)[0] = 0.5 * (all(set[0], 0) + all(set[1], 0));
    return 1;
  }
};

/// `inliers` points at 0, the others far from all.
PointMatrix Cluster(int inliers, int count) {
  PointMatrix points = PointMatrix::Zero(count, 1);
  for (int i = inliers; i < count; ++i) points(i, 0) = 10.0 * (i + 1);
  return points;
}

ConsensusOptions Plain(int max_iterations = 1000) {
  ConsensusOptions options;
  options.refit = Refit::kNone;
  options.max_iterations = max_iterations;
  return options;
}

TEST_CASE("A fixed budget is exactly that many draws") {
  const PointMatrix points = Cluster(50, 100);
  for (int budget : {1, 2, 63, 64, 65, 1000, 5000})
    for (int block : {0, 1, 50, 10000})
      for (int threads : {1, 2}) {
        ConsensusOptions options = Plain(budget);
        options.block_size = block;
        const auto result = SearchUniformly<Place>(points, 0.1, options, Rng(1), {}, threads);
        REQUIRE(result.status == Status::kOk);
        CHECK(result.iterations == budget);
        CHECK(result.hypotheses == budget);
        CHECK(result.stop == StopReason::kBudget);
      }
}

TEST_CASE("Each solution and each degenerate set is a hypothesis") {
  PointMatrix points(4, 1);
  points << 0, 0, 1, 2;
  const auto result = SearchExhaustively<TenPlaces>(points, 0.6, Plain(), Rng(1));
  CHECK(result.iterations == 6);
  CHECK(result.stop == StopReason::kExhausted);
  CHECK(result.hypotheses == 1 + 5 * 10);
  CHECK(result.unique_minimal_sets == 6);
  REQUIRE(result.status == Status::kOk);
  CHECK(result.model[0] == 0.5);
  CHECK(result.score == 3.0);
}

TEST_CASE("A source that runs out ends the search, without any set there is no model") {
  const PointMatrix points = Cluster(5, 12);
  auto result = SearchExhaustively<Place>(points, 0.1, Plain(100), Rng(1));
  CHECK(result.iterations == 12);
  CHECK(result.stop == StopReason::kExhausted);
  result = SearchExhaustively<Place>(points, 0.1, Plain(12), Rng(1));
  CHECK(result.iterations == 12);
  CHECK(result.stop == StopReason::kBudget);
  result = SearchSets<Place>(points, 0.1, {}, Plain(100), Rng(1));
  CHECK(result.status == Status::kNoModel);
  CHECK(result.iterations == 0);
  CHECK(result.stop == StopReason::kExhausted);
}

TEST_CASE("Refused points are not searched") {
  const auto result = SearchUniformly<Place>(PointMatrix(0, 1), 0.1, Plain(), Rng(1));
  CHECK(result.status == Status::kTooFewPoints);
  CHECK(result.iterations == 0);
  CHECK(result.stop == StopReason::kNotRun);
}

TEST_CASE("Confidence ends the search at the first draw that suffices, for any threads and blocks") {
  // Pairs of 30 points of which 12 agree.
  const PointMatrix points = Cluster(12, 30);
  const std::int64_t needed = DrawsForConfidence(AllInlierProbability(12, 30, 2), 0.999);
  REQUIRE(needed > 1);
  for (int seed = 0; seed < 20; ++seed) {
    // By hand: the search must have seen a good pair, and enough draws.
    UniformSampler source(30, 2, Rng(seed).Fork("minimal_sets"));
    const std::vector<int> sets = DrawSets(source, 2, 2000);
    std::int64_t first_good = 0;
    while (sets[2 * first_good + 1] >= 12) ++first_good;
    const std::int64_t expected = std::max(needed, first_good + 1);
    for (int threads : {1, 2})
      for (int block : {0, 1, 13, 1000}) {
        ConsensusOptions options = Plain(2000);
        options.stopping = Stopping::kConfidence;
        options.confidence = 0.999;
        options.block_size = block;
        auto result = SearchUniformly<Pair>(points, 0.1, options, Rng(seed), {}, threads);
        CHECK(result.iterations == expected);
        CHECK(result.hypotheses == expected);
        CHECK(result.stop == StopReason::kConfidence);
        CHECK(result.score == 12.0);
        options.min_iterations = 500;
        result = SearchUniformly<Pair>(points, 0.1, options, Rng(seed), {}, threads);
        CHECK(result.iterations == 500);
        options.max_iterations = 3;
        options.min_iterations = 0;
        result = SearchUniformly<Pair>(points, 0.1, options, Rng(seed), {}, threads);
        CHECK(result.iterations == 3);
        CHECK(result.stop == StopReason::kBudget);
      }
  }
}

TEST_CASE("The stopping rule holds for every source: given sets are not all taken once the search is confident") {
  ConsensusOptions options = Plain();
  const std::vector<int> sets{0, 1, 2, 3, 4};
  CHECK(SearchSets<Place>(Cluster(20, 20), 0.1, sets, options, Rng(1)).iterations == 5);
  options.stopping = Stopping::kConfidence;
  const auto result = SearchSets<Place>(Cluster(20, 20), 0.1, sets, options, Rng(1));
  CHECK(result.iterations == 1);
  CHECK(result.stop == StopReason::kConfidence);
  options.min_iterations = 3;
  CHECK(SearchSets<Place>(Cluster(20, 20), 0.1, sets, options, Rng(1)).iterations == 3);
}

TEST_CASE("Of equal scores the first draw wins, whatever the blocks") {
  // Pairs 0-1, 2-3, … agree; every model has two inliers.
  PointMatrix points(40, 1);
  for (int i = 0; i < 40; ++i) points(i, 0) = 10.0 * (i / 2);
  for (int seed = 0; seed < 10; ++seed) {
    UniformSampler source(40, 1, Rng(seed).Fork("minimal_sets"));
    const std::vector<int> sets = DrawSets(source, 1, 1);
    for (int block : {1, 7, 64, 1000}) {
      ConsensusOptions options = Plain();
      options.block_size = block;
      for (int threads : {1, 2}) {
        const auto result = SearchUniformly<Place>(points, 0.1, options, Rng(seed), {}, threads);
        REQUIRE(result.status == Status::kOk);
        CHECK(result.model[0] == points(sets[0], 0));
      }
    }
  }
}

TEST_CASE("A model that no minimal set's worth of points supports is none") {
  const PointMatrix points = Cluster(10, 20);
  for (const auto& [score, name] : kEnumNames<ScoreKind>) {
    ConsensusOptions options = Plain();
    options.score = options.final_score = score;
    const auto result = SearchUniformly<FarPlace>(points, 0.1, options, Rng(1));
    CHECK(result.status == Status::kNoModel);
    CHECK(result.model.size() == 0);
    CHECK(result.inliers.empty());
    CHECK(result.score == 0.0);
    CHECK(result.iterations == 1000);
    CHECK(result.stop == StopReason::kBudget);
  }
}

TEST_CASE("Support of one point fewer than a minimal set is no model, of a minimal set it is") {
  // The mean of the outer two is at the middle point: one inlier for pairs, which need two.
  PointMatrix points(3, 1);
  points << 0, 5, 10;
  for (const auto& [score, name] : kEnumNames<ScoreKind>)
    for (const auto& [refit, refit_name] : kEnumNames<Refit>) {
      CAPTURE(name, refit_name);
      ConsensusOptions options = Plain();
      options.score = options.final_score = score;
      options.refit = refit;
      const auto lonely = SearchExhaustively<Pair>(points, 0.1, options, Rng(1));
      CHECK(lonely.status == Status::kNoModel);
      CHECK(lonely.model.size() == 0);
      CHECK(lonely.inliers.empty());
      CHECK(lonely.iterations == 3);
      PointMatrix four(4, 1);
      four << 0, 5.02, 10, 4.99;
      const auto supported = SearchExhaustively<Pair>(four, 0.1, options, Rng(1));
      REQUIRE(supported.status == Status::kOk);
      CHECK(supported.inliers == std::vector<std::uint8_t>{0, 1, 0, 1});
    }
}

TEST_CASE("Priors come before the draws of a source and can end the search at once") {
  EstimationPriors priors;
  priors.models = {Eigen::VectorXd::Zero(1)};
  ConsensusOptions options = Plain(100000);
  options.stopping = Stopping::kConfidence;
  const auto result = SearchUniformly<Place>(Cluster(99, 100), 0.1, options, Rng(1), priors);
  CHECK(result.iterations == 1);
  CHECK(result.model[0] == 0.0);
  CHECK(result.hypotheses == 1);
}

TEST_CASE("A refinement is kept only where the score does not fall, in the loop and at the end") {
  // Points around 0 and the worst of them solved.
  PointMatrix points(6, 1);
  points << 0.9, -0.3, 0.0, 0.3, 0.1, 50.0;
  const std::vector<int> sets{0};
  const auto run = [&]<class Model>(LocalOptimization local, FinalRefinement last) {
    ConsensusOptions options = Plain();
    options.score = options.final_score = ScoreKind::kMsac;
    options.local_optimization = local;
    options.final_refinement = last;
    return SearchSets<Model>(points, 1.0, sets, options, Rng(1));
  };
  const auto plain = run.operator()<Place>(LocalOptimization::kNone, FinalRefinement::kNone);
  CHECK(plain.model[0] == 0.9);
  CHECK(plain.hypotheses == 1);
  for (const auto& [local, last] : {std::pair{LocalOptimization::kRefinement, FinalRefinement::kNone},
                                    {LocalOptimization::kNone, FinalRefinement::kRefinement}}) {
    const auto better = run.operator()<RefinedPlace<RefineMode::kToMean>>(local, last);
    CHECK(better.score > plain.score);
    CHECK(std::abs(better.model[0]) < 0.5);
    CHECK(better.hypotheses == 2);
    CHECK(run.operator()<RefinedPlace<RefineMode::kAway>>(local, last).model == plain.model);
    CHECK(run.operator()<RefinedPlace<RefineMode::kNaN>>(local, last).model == plain.model);
    CHECK(run.operator()<RefinedPlace<RefineMode::kRefuse>>(local, last).model == plain.model);
    // A model without the hook goes without.
    CHECK(run.operator()<Place>(local, last).model == plain.model);
    CHECK(run.operator()<Place>(local, last).hypotheses == 1);
  }
}

/// Five points around 0 and seven around 100. The first and the last are the worst of theirs to start from: the last
/// scores more than the first does, and less than what is made of the first.
PointMatrix TwoClusters() {
  PointMatrix points(12, 1);
  points << 0.9, -0.3, 0.0, 0.3, 0.1, 99.7, 100.0, 100.3, 100.1, 100.2, 99.8, 100.9;
  return points;
}

TEST_CASE("After the first improvement minimal models were never improved") {
  for (const ScoreKind score : testing::kScores)
    for (const LocalOptimization local : testing::kOptimizers)
      for (const int candidates : {1, 10}) {
        if (local == LocalOptimization::kNone) continue;
        CAPTURE(ToString(score), ToString(local), candidates);
        ConsensusOptions options = Plain();
        options.score = options.final_score = score;
        options.local_optimization = local;
        options.refit_candidates = candidates;
        const auto search = [&](const std::vector<int>& sets, const EstimationPriors& priors = {}) {
          return SearchSets<RefinedPlace<RefineMode::kToMean>>(TwoClusters(), 1.0, sets, options, Rng(1), priors);
        };
        const auto first = search({0}), last = search({11}), both = search({0, 11});
        REQUIRE(last.score > first.score);
        CHECK(std::abs(both.model[0] - 100.0) < 0.9);
        CHECK(both.score > first.score);
        // A draw that scores no more than one before it is not improved again, and ends no better.
        CHECK(search({0, 11, 0, 11}).hypotheses == both.hypotheses + 2);
        // A model that was given is as good as an improved one, and bars no draw's way either.
        EstimationPriors priors;
        priors.models = {first.model};
        CHECK(std::abs(search({11}, priors).model[0] - 100.0) < 0.9);
      }
}

TEST_CASE("A draw near the better optimum that was worse itself was never improved") {
  ConsensusOptions options = Plain();
  options.score = options.final_score = ScoreKind::kMsac;
  options.local_optimization = LocalOptimization::kRefinement;
  options.refit_candidates = 3;
  const auto search = [&](const ConsensusOptions& o) {
    return SearchSets<RefinedPlace<RefineMode::kToMean>>(TwoClusters(), 1.0, std::vector<int>{2, 11}, o, Rng(1));
  };
  CHECK(std::abs(search(options).model[0]) < 0.9);
  options.lo_starts = 2;
  const auto found = search(options);
  CHECK(std::abs(found.model[0] - 100.0) < 0.9);
  // A confident search has nothing to look for.
  options.stopping = Stopping::kConfidence;
  options.confidence = 0.01;
  CHECK(search(options).hypotheses < found.hypotheses);
}

TEST_CASE("Other starts are not asked for where all draws are as good as sure to find the best") {
  const ConsensusOptions options = Plain();
  StoppingRule rule(options, 100, 1);
  CHECK_FALSE(rule.Finds(1000000));
  rule.Update(50);
  CHECK_FALSE(rule.Finds(6));
  CHECK(rule.Finds(7));
}

TEST_CASE("Hypotheses of one basin count as one, the better of them") {
  PointMatrix points(40, 1);
  for (int i = 0; i < 40; ++i) points(i, 0) = 0.1 * i;
  const auto at = [](double place) { return Place::Parameters::Constant(place); };
  const Scorer<Place> scorer(points);
  BestHypotheses<Place> best(scorer, 1.0, 3, 0.8);
  CHECK(best.score_to_beat() == -1.0);
  best.Offer(at(1.05), 5.0);
  best.Offer(at(1.15), 4.0);  // 19 of 21 points are common.
  REQUIRE(best.entries().size() == 1);
  best.Offer(at(2.05), 4.5);
  best.Offer(at(1.15), 6.0);
  REQUIRE(best.entries().size() == 2);
  CHECK(best.entries()[0].model == at(1.15));
  CHECK(best.entries()[1].model == at(2.05));
  // Between the two, like neither enough.
  best.Offer(at(1.55), 7.0);
  best.Offer(at(3.05), 1.0);
  CHECK(best.entries().size() == 3);
  CHECK(best.score_to_beat() == 4.5);
  // One takes the place of two that it resembles, and the score to beat stays.
  BestHypotheses<Place> coarse(scorer, 1.0, 2, 0.5);
  coarse.Offer(at(1.05), 5.0);
  coarse.Offer(at(2.05), 4.5);
  coarse.Offer(at(1.55), 7.0);
  CHECK(coarse.entries().size() == 1);
  CHECK(coarse.score_to_beat() == 4.5);
  // None is kept where there is no room.
  BestHypotheses<Place> none(scorer, 1.0, 0, 0.8);
  none.Offer(at(1.0), 5.0);
  CHECK(none.entries().empty());
  // One that is far worse than the best is not asked for, though there is room.
  BestHypotheses<Place> near(scorer, 1.0, 3, 0.8, 0.5);
  near.Offer(at(1.05), 0.0);
  near.Offer(at(1.05), 5.0);
  CHECK(near.score_to_beat() == 2.5);
  near.Offer(at(2.05), 2.4);
  CHECK(near.entries().size() == 1);
}

TEST_CASE("The degeneracy hook is asked for each new best model and judged by the score") {
  PointMatrix points(8, 1);
  points << 0, 0.1, 5, 5.1, 4.9, 5.05, 20, 30;
  const auto from = [&](int index) {
    return SearchSets<MendedPlace>(points, 0.5, std::vector<int>{index}, Plain(), Rng(1));
  };
  CHECK(from(1).model[0] == 0.1);
  CHECK(from(1).hypotheses == 1);
  CHECK(from(0).model[0] == 5.0);
  CHECK(from(0).hypotheses == 4);
  // As good already: the model stays.
  CHECK(from(2).model[0] == 5.0);
  CHECK(from(4).model[0] == 4.9);
  // Point 0 gives the best model by its hook; a later model that scores less is not asked about.
  const auto both = SearchSets<MendedPlace>(points, 0.5, std::vector<int>{0, 6}, Plain(), Rng(1));
  CHECK(both.hypotheses == 5);
  CHECK(both.score == 4.0);
}

TEST_CASE("The degeneracy hook is asked again about what is not from a set: priors and optimised models") {
  PointMatrix points(8, 1);
  points << 19.9, 20.1, 29.8, 30, 30.1, 30.2, 40, 50;
  EstimationPriors priors;
  priors.models = {Eigen::VectorXd::Constant(1, 20.0)};
  const auto hinted = SearchSets<MendedPlace>(points, 0.5, std::vector<int>{}, Plain(), Rng(1), priors);
  CHECK(hinted.model[0] == 30.0);
  CHECK(hinted.hypotheses == 3);
  // Point 1 alone leads to 20 by reweighting, and 20 to 30.
  ConsensusOptions options = Plain();
  options.score = options.final_score = ScoreKind::kMsac;
  options.local_optimization = LocalOptimization::kInnerSamples;
  const auto optimized = SearchSets<MendedPlace>(points, 0.5, std::vector<int>{1}, options, Rng(1));
  CHECK(optimized.model[0] == Approx(30.0).margin(0.1));
  options.local_optimization = LocalOptimization::kNone;
  CHECK(SearchSets<MendedPlace>(points, 0.5, std::vector<int>{1}, options, Rng(1)).model[0] == 20.1);
}

TEST_CASE("Degrees of freedom without a MAGSAC++ loss are refused") {
  ConsensusOptions options = Plain();
  options.residual_dof = 9;
  options.score = ScoreKind::kMagsac;
  CHECK_THROWS_AS(SearchUniformly<Place>(Cluster(5, 10), 0.1, options, Rng(1)), Error);
}

std::int64_t Draws(std::int64_t inliers, std::int64_t points, double confidence) {
  return DrawsForConfidence(AllInlierProbability(inliers, points, 3), confidence);
}

TEST_CASE("Golden numbers of draws for sets of three") {
  CHECK(Draws(10, 100, 0.99) == 6204);
  CHECK(Draws(10, 100, 0.999) == 9305);
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

}  // namespace
}  // namespace diffsac
