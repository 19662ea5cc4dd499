#include "diffsac/estimate/presets.h"

#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <string>

#include "diffsac/diffsac.h"
#include "diffsac/estimate/estimate_options.h"
#include "estimate/owned_matches.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/eval/experiment.h"

namespace diffsac {
namespace {

const std::string kConfigs = std::string(DIFFSAC_SOURCE_DIR) + "/configs/";

/// A row of a shipped table, for its task.
std::unique_ptr<RobustEstimator> Row(const std::string& config, const std::string& name) {
  const ExperimentOptions experiment = ReadExperiment(ConfigFromFile(kConfigs + config));
  for (const EstimatorRow& row : experiment.methods)
    if (row.name == name) return MakeEstimator(row.config, experiment.task, {});
  throw Error(config + ": no row " + name);
}

std::unique_ptr<RobustEstimator> Recommended(Task task) {
  return MakeEstimator(ConfigFromYaml("{type: ransac, preset: recommended}", "row"), task, {});
}

Problem ProblemOf(const std::string& yaml) { return MakeDataset(ConfigFromYaml(yaml), 3)->Get(0).problem; }

testing::OwnedMatches MatchesOf(const Problem& problem) {
  return {problem.points.leftCols(2), problem.points.rightCols(2), problem.snn_ratio, problem.size1, problem.size2};
}

template <class Result>
void CheckSame(const Result& result, const Estimate& row) {
  REQUIRE(row.status == Status::kOk);
  REQUIRE(result.ok());
  using Layout =
      Eigen::Matrix<double, decltype(result.model)::RowsAtCompileTime, decltype(result.model)::ColsAtCompileTime,
                    decltype(result.model)::ColsAtCompileTime == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
  CHECK(result.model == Eigen::Map<const Layout>(row.model.data()));
  CHECK(result.inliers == row.inliers);
  CHECK(result.inlier_threshold == row.inlier_threshold);
  CHECK(result.stats.hypotheses == row.stats.hypotheses);
  CHECK(result.stats.iterations == row.stats.iterations);
}

ImageOptions Seeded(bool use_network) {
  ImageOptions options;
  options.guidance = use_network ? Guidance::kNetwork : Guidance::kNone;
  options.seed = 5;
  return options;
}

const char* kViews = "{type: synthetic_two_view, outlier_ratio: 0.5, num_points: 300, match_ratio: true, task: ";

}  // namespace

TEST_CASE("the functions of two views give the digits of the tables' rows") {
  for (const bool network : {true, false}) {
    const std::string name = network ? "learned_prosac" : "prosac_marginalised_confident";
    CAPTURE(name);
    const ImageOptions options = Seeded(network);
    Problem problem = ProblemOf(kViews + std::string("fundamental}"));
    problem.cameras.reset();
    SetThreshold(1.0, &problem);
    CheckSame(EstimateFundamental(MatchesOf(problem), options),
              Row("tables/learned_prosac_fundamental.yaml", name)->Run(problem, options.seed));
    problem = ProblemOf(kViews + std::string("essential}"));
    SetThreshold(1.0, &problem);
    const auto essential = EstimateEssential(MatchesOf(problem), *problem.cameras, options);
    const Estimate row_of_e = Row("tables/learned_prosac_essential.yaml", name)->Run(problem, options.seed);
    CheckSame(essential, row_of_e);
    CHECK(essential.pose);
    CHECK(essential.pose_covariance);
    CHECK(essential.pose_covariance == row_of_e.pose_covariance);
    problem = ProblemOf(kViews + std::string("homography}"));
    problem.cameras.reset();
    SetThreshold(3.0, &problem);
    const std::string row = network ? "learned_prosac" : "prosac_marginalised_confident";
    CheckSame(EstimateHomography(MatchesOf(problem), options),
              Row("tables/learned_homography.yaml", row)->Run(problem, options.seed));
  }
}

TEST_CASE("a calibrated homography has a pose") {
  Problem problem = ProblemOf(kViews + std::string("homography}"));
  SetThreshold(3.0, &problem);
  const auto estimate = EstimateCalibratedHomography(MatchesOf(problem), problem.cameras.value(), Seeded(false));
  const Estimate row = Row("tables/learned_homography.yaml", "prosac_marginalised_confident")->Run(problem, 5);
  CheckSame(estimate, row);
  REQUIRE(estimate.pose);
  CHECK(estimate.pose->rotation == row.pose->rotation);
}

TEST_CASE("functions and tables agree to the bit") {
  Problem problem = ProblemOf(kViews + std::string("essential}"));
  ImageOptions options = Seeded(true);
  for (const double threshold : {0.25, 4.0, 40.0}) {
    CAPTURE(threshold);
    options.max_residual = threshold;
    SetThreshold(threshold, &problem);
    for (const bool reversed : {false, true}) {
      if (reversed) problem.snn_ratio = 1.0 - problem.snn_ratio.array();
      const auto result = EstimateEssential(MatchesOf(problem), *problem.cameras, options);
      const Estimate row = Row("tables/learned_prosac_essential.yaml", "learned_prosac")->Run(problem, options.seed);
      CheckSame(result, row);
      CHECK(result.diagnostics.scores_ignored == row.scores_ignored);
      CHECK(result.pose->rotation == row.pose->rotation);
      CHECK(result.pose_covariance == row.pose_covariance);
    }
    problem.snn_ratio = 1.0 - problem.snn_ratio.array();
  }
}

TEST_CASE("the functions of lines and planes stop when they are confident") {
  PointOptions options{.max_residual = 0.1};
  options.seed = 5;
  const Problem problem = ProblemOf("{type: synthetic_line, outlier_ratio: 0.3}");
  const auto line = EstimateLine(problem.points, options);
  CHECK(line.stats.iterations == 50);
  const Estimate all = Row("tables/line.yaml", "ransac_em")->Run(problem, 5);
  CHECK(all.stats.iterations == 420);
  CHECK((all.model - line.model).norm() < 1e-3);
}

TEST_CASE("the functions of lines and planes, and of several, give the digits of the tables' rows") {
  PointOptions options{.max_residual = 0.1};
  options.seed = 5;
  Problem problem = ProblemOf("{type: synthetic_line, outlier_ratio: 0.6}");
  CheckSame(EstimateLine(problem.points, options), Recommended(Task::kLine)->Run(problem, 5));
  problem = ProblemOf("{type: synthetic_plane, outlier_ratio: 0.6}");
  CheckSame(EstimatePlane(problem.points, options), Recommended(Task::kPlane)->Run(problem, 5));
  problem = ProblemOf("{type: synthetic_structures, task: line, structures: 3, num_points: 150, outlier_ratio: 0.2}");
  const Estimate row = Row("tables/multi_line.yaml", "napsac_1000")->Run(problem, 5);
  const auto lines = EstimateMultipleLines(problem.points, options);
  REQUIRE(lines.models.size() == row.instances.size());
  CHECK(lines.models.size() >= 2);
  for (std::size_t i = 0; i < lines.models.size(); ++i) CHECK(lines.models[i] == row.instances[i]);
  CHECK(lines.assignment == row.assignment);
}

TEST_CASE("a row's preset is the start of its keys, another name is refused with its line") {
  const auto resolved = [](const std::string& row) {
    return ResolvedRow(ConfigFromYaml(row, "t.yaml"), Task::kFundamental, {});
  };
  const Config row = resolved("{type: prosac, preset: recommended, max_iterations: 300}");
  CHECK(row.Text("max_iterations") == "300");
  CHECK(row.Text("consensus.least_scale") == "0.5");
  CHECK(ToYaml(resolved(ToYaml(row))) == ToYaml(row));
  CHECK(resolved("{type: napsac, preset: several}").Text("instances.search") == "at_once");
  CHECK(resolved("{type: napsac, preset: several}").Text("sampling.sampler") == "napsac");
  CHECK_THROWS_WITH(resolved("# a row\n{type: prosac, preset: recomended}"),
                    Catch::StartsWith("t.yaml:2: preset: expected") && Catch::Contains("did you mean 'recommended'"));
}

TEST_CASE("options in C++ are held to their limits, the message names field and expectation") {
  EstimateOptions options;
  CHECK_NOTHROW(options.Check());
  options.max_iterations = -1;
  CHECK_THROWS_WITH(options.Check(), "max_iterations: expected from 1 to 10000000");
  CHECK_THROWS_WITH(EstimateLine(Points2DView(), {.max_residual = 0.0}), Catch::StartsWith("max_residual: expected"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(EstimateFundamental({}, {.max_residual = nan}), Catch::StartsWith("max_residual: expected"));
  CHECK_THROWS_AS(EstimatePlane({}, {}), std::invalid_argument);
}

TEST_CASE("fewer draws than the least that confidence asks for are possible") {
  const Problem problem = ProblemOf(kViews + std::string("fundamental}"));
  for (const bool network : {true, false}) {
    ImageOptions options = Seeded(network);
    options.max_iterations = 20;
    const auto estimate = EstimateFundamental(MatchesOf(problem), options);
    CHECK(estimate.ok());
    CHECK(estimate.stats.iterations <= 20);
  }
}

}  // namespace diffsac
