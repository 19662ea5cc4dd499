// What the loop promises, for all six models (F by 7 and by 8 points) and every source: masks that are the residuals'
// own, the same bits for any threads and blocks, a status for whatever data, and models that come out right.

#include "ransac/all_models.h"
#include "diffsac/ransac/option_names.h"
#include "lab/config/yaml.h"
#include "ransac/random_problems.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <type_traits>
#include <vector>

namespace diffsac {
namespace {

using testing::AllSamplers;
using testing::ForEachCombination;
using testing::MakeModelProblem;
using testing::MakeQuality;
using testing::ModelProblem;
using testing::SearchUniformly;

#define DIFFSAC_ALL_MODELS \
  Line, Plane, Homography, Fundamental, Fundamental8, Essential, AbsolutePose, Rigid, Similarity

void CheckSame(const ConsensusResult& a, const ConsensusResult& b) {
  CHECK(a.status == b.status);
  REQUIRE(a.model.size() == b.model.size());
  CHECK(a.model == b.model);
  CHECK(a.inliers == b.inliers);
  CHECK(a.score == b.score);
  CHECK(a.hypotheses == b.hypotheses);
  CHECK(a.iterations == b.iterations);
  CHECK(a.stop == b.stop);
  CHECK(a.unique_minimal_sets == b.unique_minimal_sets);
}

/// What holds for any result: without a model nothing is claimed; with one, the mask is `residual ≤ threshold` of each
/// point, and a score that can be had from the residuals alone is theirs.
template <MinimalModel Model>
void CheckAgainstResiduals(const ModelProblem& problem, const ConsensusOptions& options,
                           const ConsensusResult& result) {
  if (result.status != Status::kOk) {
    CHECK(result.model.size() == 0);
    CHECK(result.inliers.empty());
    CHECK(result.score == 0.0);
    return;
  }
  REQUIRE(result.model.size() == Model::Parameters::SizeAtCompileTime);
  REQUIRE(result.model.allFinite());
  const typename Model::Parameters model = result.model;
  const int count = static_cast<int>(problem.points.rows());
  REQUIRE(static_cast<int>(result.inliers.size()) == count);
  int wrong = 0, inliers = 0;
  double msac = 0.0;
  for (int i = 0; i < count; ++i) {
    const double residual = Model::Residual(model, problem.points.data() + i * Model::kDimension);
    const bool near = residual <= problem.threshold;
    wrong += result.inliers[i] != (near ? 1 : 0);
    inliers += near;
    if (near) msac += 1.0 - residual * residual / (problem.threshold * problem.threshold);
  }
  CHECK(wrong == 0);
  CHECK(inliers >= Model::kMinimalSize);
  if (options.final_score == ScoreKind::kInlierCount) CHECK(result.score == inliers);
  if (options.final_score == ScoreKind::kMsac) CHECK(result.score == Approx(msac).epsilon(1e-12));
}

TEMPLATE_TEST_CASE("Masks are the residuals' own, for every model, source, score and optimiser", "",
                   DIFFSAC_ALL_MODELS) {
  const ModelProblem problem = MakeModelProblem<TestType>(70, 0.3, Rng(1));
  const std::vector<double> quality = MakeQuality(70, problem.outliers, Rng(2));
  int found = 0, all = 0;
  const AllSamplers sources(problem.points, TestType::kMinimalSize, quality, problem.threshold);
  for (const auto& [name, make] : sources) {
    ForEachCombination(all, [&, &make = make](ConsensusOptions options) {
      options.max_iterations = 40;
      CAPTURE(name, WriteYaml(options));
      const auto source = make(all);
      const auto result =
          SampleConsensus<TestType>(problem.points, problem.threshold, *source, options, Rng(all), {}, 1);
      CheckAgainstResiduals<TestType>(problem, options, result);
      found += result.status == Status::kOk ? 1 : 0;
      ++all;
    });
  }
  // The first sets of the exhaustive source, one of eleven, share all but one point, and may have no model among them.
  CHECK(found >= all - all / 8);
}

TEMPLATE_TEST_CASE("1 and 8 threads and any block give the same bits, for every model, source, score and optimiser", "",
                   DIFFSAC_ALL_MODELS) {
  const ModelProblem problem = MakeModelProblem<TestType>(70, 0.4, Rng(3));
  const std::vector<double> quality = MakeQuality(70, problem.outliers, Rng(4));
  constexpr int kBlocks[] = {1, 3, 17, 37, 64, 1000};
  int i = 0;
  const AllSamplers sources(problem.points, TestType::kMinimalSize, quality, problem.threshold);
  for (const auto& [name, make] : sources) {
    ForEachCombination(i, [&, &make = make](ConsensusOptions options) {
      options.max_iterations = 50;
      CAPTURE(name, WriteYaml(options));
      const auto run = [&](int threads, int block) {
        options.block_size = block;
        const auto source = make(i);
        return SampleConsensus<TestType>(problem.points, problem.threshold, *source, options, Rng(i), {}, threads);
      };
      const ConsensusResult one = run(1, 0);
      CheckSame(one, run(8, 0));
      CheckSame(one, run(i % 2 ? 8 : 1, kBlocks[i % 6]));
      ++i;
    });
  }
}

/// The share of the true model's inliers (outliers that fit it by chance left out) that the result has too.
template <MinimalModel Model>
double ShareOfTrueInliers(const ModelProblem& problem, const ConsensusResult& result) {
  const typename Model::Parameters truth = problem.truth;
  const std::vector<std::uint8_t> expected = InlierMask<Model>(problem.points, truth, problem.threshold);
  int both = 0, all = 0;
  for (std::size_t i = problem.outliers; i < expected.size(); ++i) {
    all += expected[i];
    both += expected[i] && result.inliers[i];
  }
  return all > 0 ? static_cast<double>(both) / all : 0.0;
}

/// Data of one kind for every model, and the status that it must have.
struct Hostile {
  std::string name;
  PointMatrix points;
  double threshold;
  std::vector<Status> allowed;
};

/// Every point on one line in its (first) image or in space; the line of a hyperplane problem is a model.
template <MinimalModel Model>
PointMatrix Collinear(const PointMatrix& points) {
  PointMatrix line = points;
  for (int j = 1; j < (Model::kDimension == 4 ? 2 : Model::kDimension); ++j) line.col(j) = 0.5 * j * line.col(0);
  return line;
}

template <MinimalModel Model>
std::vector<Hostile> HostileCases() {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  constexpr int kSize = Model::kMinimalSize;
  const ModelProblem good = MakeModelProblem<Model>(40, 0.2, Rng(5));
  const ModelProblem clean = MakeModelProblem<Model>(kSize, 0.0, Rng(6));
  const double threshold = good.threshold;
  const std::vector<Status> ok{Status::kOk}, degenerate{Status::kDegenerate}, few{Status::kTooFewPoints},
      any_model{Status::kOk, Status::kNoModel};
  std::vector<Hostile> cases;
  cases.push_back({"as it is", good.points, threshold, ok});
  for (const int count : {0, 1, kSize - 1})
    cases.push_back({"too few: " + std::to_string(count), good.points.topRows(count), threshold, few});
  cases.push_back({"a minimal set", clean.points, clean.threshold, ok});
  cases.push_back({"identical", good.points.row(0).replicate(40, 1), threshold, degenerate});
  cases.push_back({"zero", PointMatrix::Zero(40, Model::kDimension), threshold, degenerate});
  cases.push_back(
      {"collinear", Collinear<Model>(good.points), threshold, std::is_same_v<Model, Line> ? ok : degenerate});
  for (const double bad : {kNan, kInf, -kInf}) {
    PointMatrix broken = good.points;
    broken(7, 1) = bad;
    cases.push_back({"one value not finite", broken, threshold, degenerate});
    cases.push_back({"nothing finite", PointMatrix::Constant(40, Model::kDimension, bad), threshold, degenerate});
  }
  cases.push_back({"a column too many", PointMatrix::Random(40, Model::kDimension + 1), threshold, degenerate});
  for (const double scale : {1e-8, 1e8}) {
    // Normalised coordinates have no unit: at another scale they are another, absurd problem.
    cases.push_back({"scale " + std::to_string(scale), scale * good.points, scale * threshold,
                     std::is_same_v<Model, Essential> || std::is_same_v<Model, AbsolutePose> ? any_model : ok});
  }
  PointMatrix twins = good.points;
  for (int i = 20; i < 40; ++i) twins.row(i) = twins.row(19);
  // Few draws have seven or eight different points of which none is an outlier.
  cases.push_back({"repeated", twins, threshold, kSize >= 7 ? any_model : ok});
  PointMatrix coplanar = good.points;
  if constexpr (Model::kDimension == 4) {
    Rng rng(7);
    coplanar = testing::HomographyPoints(testing::RandomHomography(rng), 40, rng);
    if (std::is_same_v<Model, Essential>) coplanar = 1e-3 * coplanar;
  } else if constexpr (std::is_same_v<Model, AbsolutePose>) {
    coplanar = testing::MakeAbsolutePoseScene(40, 0.2, 1e-3, Rng(7), 0.0).points;
  } else if constexpr (Model::kDimension == 6) {
    coplanar =
        testing::MakeCloudScene(40, 0.2, 0.01, Rng(7), std::is_same_v<Model, Similarity> ? 2.0 : 1.0, 0.0).points;
  } else {
    coplanar.col(Model::kDimension - 1).setConstant(3.0);
  }
  // A plane has a homography, and more than one F and E that fit it.
  const bool unique = !std::is_same_v<Model, Essential> && !std::is_base_of_v<Fundamental, Model>;
  cases.push_back({"coplanar", coplanar, threshold, unique ? ok : any_model});
  PointMatrix still = good.points;
  if (Model::kDimension == 4) still.rightCols(2) = still.leftCols(2).eval();
  cases.push_back({"no motion", still, threshold, any_model});
  return cases;
}

TEMPLATE_TEST_CASE("Hostile points give a status, for every model, source, score and optimiser", "",
                   DIFFSAC_ALL_MODELS) {
  int shift = 0;
  for (const Hostile& hostile : HostileCases<TestType>()) {
    const ModelProblem problem{hostile.points, hostile.threshold, 0, {}};
    const int count = static_cast<int>(problem.points.rows());
    const std::vector<double> quality(count, 0.0);  // all weights zero, all qualities equal
    const AllSamplers sources(problem.points, TestType::kMinimalSize, quality, problem.threshold);
    for (const auto& [name, make] : sources) {
      int combination = 0;
      ForEachCombination(++shift, [&, &name = name, &make = make](ConsensusOptions options) {
        // A quarter of the combinations for each source and case; every optimiser and score with each over the cases.
        if (combination++ % 4 != shift % 4) return;
        options.max_iterations = name == "exhaustive" ? 400 : 30;
        options.stopping = Stopping::kBudget;
        EstimationPriors priors;
        priors.fit_weights = Eigen::VectorXd::Zero(count);
        const auto source = make(1);
        const auto result =
            SampleConsensus<TestType>(problem.points, problem.threshold, *source, options, Rng(1), priors);
        CAPTURE(hostile.name, name, WriteYaml(options), std::string(ToString(result.status)));
        // Sources that see few different sets may miss a model that is there.
        const bool thorough = name == "uniform" || name == "weighted";
        const bool allowed = std::count(hostile.allowed.begin(), hostile.allowed.end(), result.status) > 0 ||
                             (!thorough && hostile.allowed[0] == Status::kOk && result.status == Status::kNoModel);
        CHECK(allowed);
        CheckAgainstResiduals<TestType>(problem, options, result);
      });
    }
  }
}

TEMPLATE_TEST_CASE("A hint whose residuals overflow leaves the score finite", "", DIFFSAC_ALL_MODELS) {
  const ModelProblem problem = MakeModelProblem<TestType>(40, 0.2, Rng(12));
  for (const ScoreKind score : testing::kScores)
    for (const Refit refit : testing::kRefits) {
      CAPTURE(ToString(score), ToString(refit));
      ConsensusOptions options;
      options.score = options.final_score = score;
      options.refit = refit;
      options.max_iterations = 50;
      options.refit_candidates = 3;
      EstimationPriors priors;
      priors.models = {1e308 * problem.truth, ModelParameters::Constant(problem.truth.size(), 1.7e308), problem.truth};
      priors.models[2][2] = 1.7e308;
      const auto result = SearchUniformly<TestType>(problem.points, problem.threshold, options, Rng(1), priors);
      REQUIRE(result.status == Status::kOk);
      CHECK(std::isfinite(result.score));
      CheckAgainstResiduals<TestType>(problem, options, result);
    }
}

TEMPLATE_TEST_CASE("Another unit gives the same inliers", "", Line, Plane, Homography, Fundamental, Fundamental8) {
  const ModelProblem problem = MakeModelProblem<TestType>(100, 0.3, Rng(8));
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMsac;
  options.local_optimization = LocalOptimization::kInnerSamples;
  options.max_iterations = 300;
  const auto run = [&](double scale) {
    return SearchUniformly<TestType>(scale * problem.points, scale * problem.threshold, options, Rng(1));
  };
  const ConsensusResult plain = run(1.0);
  REQUIRE(plain.status == Status::kOk);
  for (const double scale : {1e-8, 1e-3, 1e8}) {
    CAPTURE(scale);
    const ConsensusResult other = run(scale);
    REQUIRE(other.status == Status::kOk);
    CHECK(other.inliers == plain.inliers);
    CHECK(other.score == Approx(plain.score).epsilon(1e-6));
  }
}

TEMPLATE_TEST_CASE("A million points, for every model", "", DIFFSAC_ALL_MODELS) {
  constexpr int kCount = 1000000;
  const ModelProblem problem = MakeModelProblem<TestType>(kCount, 0.2, Rng(9));
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMsac;
  options.stopping = Stopping::kConfidence;
  const auto result = SearchUniformly<TestType>(problem.points, problem.threshold, options, Rng(1), {}, 0);
  REQUIRE(result.status == Status::kOk);
  CHECK(result.stop == StopReason::kConfidence);
  CHECK(ShareOfTrueInliers<TestType>(problem, result) > 0.9);  // after one least squares
  CheckAgainstResiduals<TestType>(problem, options, result);
}

TEST_CASE("A million points, for every source") {
  constexpr int kCount = 1000000;
  const ModelProblem problem = MakeModelProblem<Line>(kCount, 0.5, Rng(10));
  const std::vector<double> quality = MakeQuality(kCount, problem.outliers, Rng(11));
  ConsensusOptions options;
  options.max_iterations = 4;
  options.refit = Refit::kNone;
  for (const auto& [kind, name] : kEnumNames<MinimalSamplerKind>) {
    CAPTURE(name);
    MinimalSamplerOptions source_options;
    source_options.sampler = kind;
    const auto source = MakeMinimalSampler(source_options, problem.points, 2, Rng(1), quality);
    const auto result = SampleConsensus<Line>(problem.points, problem.threshold, *source, options, Rng(1), {}, 2);
    CHECK(result.status == Status::kOk);
    CHECK(result.iterations == 4);
    CheckAgainstResiduals<Line>(problem, options, result);
  }
}

TEMPLATE_TEST_CASE("Every model is recovered from 20 to 50 % outliers", "", DIFFSAC_ALL_MODELS) {
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMsac;
  options.score_threshold_factor = 1.5;
  options.local_optimization = LocalOptimization::kInnerSamples;
  options.refit = Refit::kIterated;
  options.final_refinement = FinalRefinement::kRefinement;
  options.max_iterations = 1500;
  options.stopping = Stopping::kConfidence;
  options.confidence = 0.9999;
  for (const double outliers : {0.2, 0.5}) {
    int recovered = 0;
    for (int trial = 0; trial < 40; ++trial) {
      const ModelProblem problem = MakeModelProblem<TestType>(150, outliers, Rng(trial).Fork("every model"));
      const auto result = SearchUniformly<TestType>(problem.points, problem.threshold, options, Rng(trial));
      recovered += result.status == Status::kOk && ShareOfTrueInliers<TestType>(problem, result) > 0.9 ? 1 : 0;
    }
    CAPTURE(outliers, recovered);
    CHECK(recovered >= 39);
  }
}

}  // namespace
}  // namespace diffsac
