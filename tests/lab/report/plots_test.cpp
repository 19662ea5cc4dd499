#include "lab/report/plots.h"
#include "lab/config/yaml.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/problem/tasks.h"
#include "lab/eval/factor_fixtures.h"
#include "lab/report/colours.h"
#include "lab/report/gnuplot.h"
#include "lab/report/plot_series.h"

namespace diffsac {
namespace {

using namespace testing;

bool IsPng(const std::string& path) {
  return std::filesystem::exists(path) && ReadFile(path).substr(0, 4) == "\x89PNG";
}

/// A block of data in gnuplot's script; empty where there is none.
std::string BlockText(const std::string& script, const std::string& name) {
  const std::string start = "$" + name + " << EOD\n";
  const std::size_t at = script.find(start);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + start.size();
  return script.substr(begin, script.find("EOD\n", begin) - begin);
}

/// Its numbers, a row a point.
std::vector<std::vector<double>> BlockOf(const std::string& script, const std::string& name) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(BlockText(script, name));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream numbers(line);
    std::vector<double> row;
    for (double value = 0.0; numbers >> value;) row.push_back(value);
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

TEST_CASE("pictures are drawn where gnuplot is") {
  const TemporaryFolder folder;
  ExperimentOptions experiment = SmallExperiment();
  experiment.figures.budget = {{"Two points", {"first", "second"}}};
  experiment.figures.bars = {"first", "second"};
  ExperimentResults results = RunExperiment(experiment, TwoPointInputs());
  // These methods report no time, which is no place on a logarithmic axis.
  CHECK_FALSE(PlotTime(MakeReport(results), folder.path()));
  CHECK_FALSE(std::filesystem::exists(folder.File("time.gp")));
  for (Cell& cell : results.cells)
    for (ProblemRecord& record : cell.records) record.report.ms_total = 0.5;
  DrawFigures(MakeReport(results), folder.path());
  for (const char* name : {"curve", "bars", "budget", "time", "fits"}) {
    INFO(name);
    CHECK(std::filesystem::exists(folder.File(name + std::string(".gp"))));
    CHECK(IsPng(folder.File(name + std::string(".png"))) == HasGnuplot());
  }
}

TEST_CASE("the reverse steps are drawn for every task") {
  const TemporaryFolder folder;
  for (const Task task : {Task::kLine, Task::kPlane, Task::kHomography, Task::kFundamental, Task::kEssential}) {
    Problem problem;
    problem.task = task;
    problem.points = PointMatrix::Random(20, PointDimension(task));
    ConfidenceTrace trace;
    for (int step = 0; step < 12; ++step) {
      trace.timesteps.push_back(100 - step);
      trace.confidence.emplace_back(20, static_cast<float>(step) / 12.0f);
    }
    const std::string path = folder.File(ToString(task) + ".png");
    CHECK(PlotConfidenceTrace(problem, trace, path) == HasGnuplot());
    CHECK(IsPng(path) == HasGnuplot());
    trace.confidence.back().pop_back();
    CHECK_FALSE(PlotConfidenceTrace(problem, trace, folder.File("none.png")));
  }
}

TEST_CASE("degenerate fits are no obstacle") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpResults();
  Example example;
  example.problem.points = PointMatrix::Constant(3, 2, std::nan(""));
  results.fits.push_back({0, example, Estimate()});
  example.problem.points.resize(0, 2);
  results.fits.push_back({1, example, Estimate()});
  CHECK(PlotFits(results, folder.path()) == HasGnuplot());
}

/// Two fits of one made-up pair: ten matches of which the second half is wrong.
ExperimentResults MatchResults() {
  ExperimentResults results = MadeUpPoses();
  Example example;
  example.id = "scene/left-right";
  example.scene = "scene";
  example.problem.task = Task::kFundamental;
  example.problem.size1 = {80, 60};
  example.problem.size2 = {60, 80};
  example.problem.points.resize(10, 4);
  for (int i = 0; i < 10; ++i) example.problem.points.row(i) << 5.0 + 7.0 * i, 30.0, 30.0, 5.0 + 7.0 * i;
  example.truth.inliers = {1, 1, 1, 1, 1, 0, 0, 0, 0, 0};
  Estimate estimate;
  estimate.status = Status::kOk;
  estimate.model = ModelParameters::Ones(9);
  estimate.inliers = {1, 0, 1, 1, 1, 1, 0, 0, 0, 0};
  results.fits.push_back({0, example, estimate, 0});
  results.fits.push_back({0, example, Estimate(), 1});
  return results;
}

int Pixels(const cv::Mat& image, const std::function<bool(const cv::Vec3b&)>& is) {
  int count = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) count += is(image.at<cv::Vec3b>(y, x));
  return count;
}

TEST_CASE("matches are drawn in the colours of what is true of them") {
  const TemporaryFolder folder;
  ExperimentResults results = MatchResults();
  REQUIRE(PlotMatches(results, folder.path()));
  const cv::Mat picture = cv::imread(folder.File("matches_all_scene_left-right_first.png"));
  const cv::Mat failed = cv::imread(folder.File("matches_all_scene_left-right_second.png"));
  REQUIRE_FALSE(picture.empty());
  REQUIRE(picture.size() == failed.size());
  const auto green = [](const cv::Vec3b& p) { return p[1] > p[0] + 60 && p[1] > p[2] + 60; };
  const auto red = [](const cv::Vec3b& p) { return p[2] > p[0] + 100 && p[2] > p[1] + 100; };
  const auto blue = [](const cv::Vec3b& p) { return p[0] > p[2] + 60; };
  CHECK(Pixels(picture, green) > 0);
  CHECK(Pixels(picture, red) > 0);
  CHECK(Pixels(picture, blue) > 0);
  CHECK(Pixels(failed, green) == 0);
  CHECK(Pixels(failed, red) == 0);
  CHECK(Pixels(failed, blue) > Pixels(picture, blue));
}

TEST_CASE("matches are drawn on the images of their scene") {
  const TemporaryFolder folder;
  ExperimentResults results = MatchResults();
  cv::imwrite(folder.File("left.png"), cv::Mat(60, 80, CV_8UC3, cv::Scalar(0, 0, 0)));
  cv::imwrite(folder.File("right.bmp"), cv::Mat(80, 60, CV_8UC3, cv::Scalar(0, 0, 0)));
  results.experiment.figures.images = {{"other", "none"}, {"sc*", folder.path()}};
  REQUIRE(PlotMatches(results, folder.path()));
  const cv::Mat picture = cv::imread(folder.File("matches_all_scene_left-right_second.png"));
  const auto dark = [](const cv::Vec3b& p) { return std::max({p[0], p[1], p[2]}) < 120; };
  CHECK(Pixels(picture, dark) > static_cast<int>(picture.total()) / 2);
}

TEST_CASE("pairs that say little are drawn as well") {
  const TemporaryFolder folder;
  ExperimentResults results = MatchResults();
  for (KeptFit& fit : results.fits) {
    fit.example.id = "no_pair";
    fit.example.truth.inliers.clear();
    fit.example.problem.size1 = fit.example.problem.size2 = {};
    fit.example.problem.points(3, 1) = std::nan("");
    fit.example.problem.points(4, 2) = 1e9;
    fit.example.problem.points(5, 0) = -1e9;
  }
  results.fits[1].example.problem.points.resize(0, 4);
  CHECK(PlotMatches(results, folder.path()));
  CHECK(IsPng(folder.File("matches_all_no_pair_first.png")));
  CHECK(IsPng(folder.File("matches_all_no_pair_second.png")));
  results.fits.clear();
  CHECK_FALSE(PlotMatches(results, folder.path()));
  results = MadeUpResults();
  results.fits.emplace_back();
  CHECK_FALSE(PlotMatches(results, folder.path()));
}

TEST_CASE("several structures have a colour each, in the fits") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpStructures();
  const Example example = LinesCross();
  results.fits = {{0, example, LinesFound(example), 0}, {1, example, Estimate(), 0}};
  REQUIRE(PlotFits(results, folder.path()) == HasGnuplot());
  const std::string script = ReadFile(folder.File("fits.gp"));
  for (int k = 0; k < 3; ++k)
    CHECK(script.find("$fit0_s" + std::to_string(k) + "_est with lines") != std::string::npos);
  CHECK(script.find("recall 1.00, error 0.0 %") != std::string::npos);
  // Each has its own points, and its line goes through them.
  for (int k = 0; k < 3; ++k) {
    const auto points = BlockOf(script, "fit0_s" + std::to_string(k));
    REQUIRE(points.size() == 10);
    CHECK(points[9][0] == Approx(example.problem.points(10 * k + 9, 0)));
    CHECK(points[9][1] == Approx(example.problem.points(10 * k + 9, 1)));
    const auto line = BlockOf(script, "fit0_s" + std::to_string(k) + "_est");
    REQUIRE(line.size() == 2);
    for (const auto& end : line)
      CHECK(std::abs(example.truth.structures[k].dot(Eigen::Vector3d(end[0], end[1], 1.0))) < 1e-3);
  }
  CHECK(BlockOf(script, "fit0_out").size() == 6);
  CHECK(script.find("true lines") != std::string::npos);
  CHECK(script.find("$fit1_s0") == std::string::npos);
}

TEST_CASE("of many conditions the reliability of four is drawn, from the first to the last") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpResults();
  const Condition first = results.experiment.conditions[0];
  results.experiment.conditions.clear();
  for (int c = 0; c < 7; ++c) {
    Condition condition = first;
    condition.name = condition.label = "condition" + std::to_string(c);
    results.experiment.conditions.push_back(condition);
    ReliabilityCurve curve{"row", static_cast<std::size_t>(c), {}};
    curve.scenes["s"].Add(std::vector<float>{0.5f}, std::vector<std::uint8_t>{1});
    results.reliability.push_back(curve);
  }
  CHECK(PlotReliability(results, folder.path()) == HasGnuplot());
  const std::string script = ReadFile(folder.File("reliability.gp"));
  for (int c = 0; c < 7; ++c)
    CHECK((script.find("condition" + std::to_string(c)) != std::string::npos) == (c % 2 == 0));
}

TEST_CASE("segments are drawn from end to end, in the colour of their vanishing point") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpResults();
  results.experiment.task = Task::kVanishingPoint;
  KeptFit fit{};
  fit.example.problem.task = Task::kVanishingPoint;
  fit.example.problem.points.resize(3, 4);
  fit.example.problem.points << 10, 20, 30, 40, 5, 6, 7, 8, 90, 80, 70, 60;
  fit.estimate.status = Status::kOk;
  fit.estimate.model = Eigen::Vector3d(1, 0, 0);
  fit.estimate.structures = {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0)};
  fit.estimate.assignment = {2, 0, 1};
  fit.estimate.inliers = {1, 0, 1};
  results.fits = {fit};
  REQUIRE(PlotFits(results, folder.path()) == HasGnuplot());
  const std::string script = ReadFile(folder.File("fits.gp"));
  using Rows = std::vector<std::vector<double>>;
  CHECK(BlockOf(script, "fit0_s0") == Rows{{90, 80}, {70, 60}});
  CHECK(BlockOf(script, "fit0_s1") == Rows{{10, 20}, {30, 40}});
  CHECK(BlockOf(script, "fit0_out") == Rows{{5, 6}, {7, 8}});
  CHECK(script.find(std::string("$fit0_s1 with lines lw 2 lc rgb \"") + StructureColour(1)) != std::string::npos);
}

TEST_CASE("an estimated plane is drawn as a mesh where its inliers are") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpResults();
  results.experiment.task = Task::kPlane;
  KeptFit fit{};
  fit.example.problem.task = Task::kPlane;
  fit.example.problem.points.resize(6, 3);
  fit.example.problem.points << 0, 0, 1, 4, 0, 1, 4, 2, 1, 0, 2, 1, 9, 9, 9, -5, 0, 3;
  fit.estimate.status = Status::kOk;
  fit.estimate.model = Eigen::Vector4d(0, 0, 1, -1);
  fit.estimate.inliers = {1, 1, 1, 1, 0, 0};
  results.fits = {fit};
  REQUIRE(PlotFits(results, folder.path()) == HasGnuplot());
  const auto mesh = BlockOf(ReadFile(folder.File("fits.gp")), "fit0_est");
  const auto side = static_cast<std::size_t>(std::lround(std::sqrt(mesh.size())));
  REQUIRE((side > 1 && side * side == mesh.size()));
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  for (const auto& row : mesh) {
    low = low.cwiseMin(Eigen::Vector3d(row[0], row[1], row[2]));
    high = high.cwiseMax(Eigen::Vector3d(row[0], row[1], row[2]));
  }
  CHECK((low - Eigen::Vector3d(0, 0, 1)).norm() < 1e-3);
  CHECK((high - Eigen::Vector3d(4, 2, 1)).norm() < 1e-3);
}

TEST_CASE("several structures have a colour each, found beside true") {
  const TemporaryFolder folder;
  ExperimentResults results = MatchResults();
  for (KeptFit& fit : results.fits) {
    fit.example.truth.assignment.clear();
    for (const std::uint8_t inlier : fit.example.truth.inliers)
      fit.example.truth.assignment.push_back(inlier != 0 ? 1 : 0);
    fit.example.truth.structures = {Eigen::VectorXd::Ones(9)};
  }
  REQUIRE(PlotMatches(results, folder.path()));
  const cv::Mat picture = cv::imread(folder.File("matches_all_scene_left-right_first.png"));
  const cv::Mat failed = cv::imread(folder.File("matches_all_scene_left-right_second.png"));
  const auto of_first = [](const cv::Vec3b& p) { return p == cv::Vec3b(0xB2, 0x72, 0x00); };
  const auto half = [](const cv::Mat& whole, int side) {
    return whole(cv::Rect(side * whole.cols / 2, 0, whole.cols / 2, whole.rows));
  };
  CHECK(Pixels(half(picture, 0), of_first) > 0);
  CHECK(Pixels(half(picture, 1), of_first) > 0);
  CHECK(Pixels(half(failed, 0), of_first) == 0);
  CHECK(Pixels(half(failed, 1), of_first) > 0);  // The truth, whatever was found.
}

TEST_CASE("two views keep the matches of several rows, spread over the data") {
  ExperimentOptions experiment = ReadExperiment(ConfigFromYaml(R"(
name: views
task: fundamental
problems: 9
data: {type: synthetic_two_view, task: fundamental, num_points: 30}
methods:
  - {name: a, type: failing}
  - {name: b, type: failing}
  - {name: oracle, type: oracle}
  - {name: c, type: failing}
  - {name: d, type: failing}
figures: {qualitative: 3, images: [{scenes: "x*", folder: images}]}
)"));
  struct Failing : RobustEstimator {
    diffsac::Estimate DoRun(const Problem&, std::uint64_t) const override { return {}; }
  };
  const RunInputs inputs{[](const Config&, Task) { return std::make_unique<Failing>(); }, {}, nullptr};
  const ExperimentResults results = RunExperiment(experiment, inputs);
  REQUIRE(results.fits.size() == 9);
  CHECK(results.fits[0].method == 0);
  CHECK(results.fits[3].method == 1);
  CHECK(results.fits[6].method == 3);  // The oracle is left out.
  CHECK(results.fits[1].example.index == 3);
  CHECK(results.fits[2].example.index == 6);
  experiment.figures.qualitative_methods = {"d"};
  CHECK(RunExperiment(experiment, inputs).fits.front().method == 4);
  const std::string once = WriteExperiment(experiment);
  CHECK(WriteExperiment(ReadExperiment(ConfigFromYaml(once))) == once);
}

TEST_CASE("bars are the table's means with their intervals; poses have rotation and translation") {
  const TemporaryFolder folder;
  ExperimentOptions experiment = SmallExperiment();
  experiment.figures.bars = {"second"};
  ExperimentResults results = RunExperiment(experiment, TwoPointInputs());
  REQUIRE(PlotBars(MakeReport(results), folder.path()) == HasGnuplot());
  const auto data = [&] { return BlockText(ReadFile(folder.File("bars.gp")), "bars"); };
  const auto lines = data();
  CHECK(std::count(lines.begin(), lines.end(), '\n') == static_cast<int>(experiment.conditions.size()));
  const Cell* cell = results.Find(0, experiment.RowOf("second"));
  const Tolerance c = experiment.tolerance();
  const double mean = FindMetric(CellMetrics(*cell, c), "mean", MetricName("mAA", c));
  CHECK(std::stod(lines.substr(lines.find('"', 1) + 1)) == Approx(mean).margin(1e-6));

  for (Cell& known : results.cells)
    for (ProblemRecord& record : known.records) record.error.rotation_deg = record.error.translation_deg = 0.1;
  PlotBars(MakeReport(results), folder.path());
  const auto poses = data();
  CHECK(std::count(poses.begin(), poses.end(), '\n') == 2 * static_cast<int>(experiment.conditions.size()));
  CHECK(poses.find(", R\"") != std::string::npos);
}

TEST_CASE("effects are a dot a level, the first at 0 and at 1, conditions beside each other") {
  const TemporaryFolder folder;
  const ExperimentResults results = MixedFactors();
  const Report report = MakeReport(results);
  CHECK(PlotEffects(report, folder.path()) == HasGnuplot());
  const std::string script = ReadFile(folder.File("effects.gp"));
  for (std::size_t c = 0; c < 2; ++c) {
    const auto dots = BlockOf(script, "accuracy" + std::to_string(c)), ms = BlockOf(script, "ms" + std::to_string(c));
    REQUIRE(dots.size() == 5);
    REQUIRE(ms.size() == 5);
    CHECK(dots[0] == std::vector<double>{dots[0][0], 0.0, 0.0, 0.0});
    CHECK(ms[2] == std::vector<double>{ms[2][0], 1.0, 1.0, 1.0});
    const ConfidenceInterval& effect = *report.effects[c][1][2].accuracy;
    CHECK(dots[4][1] == Approx(effect.mean));
    CHECK(dots[4][2] == Approx(effect.low));
    CHECK(dots[4][3] == Approx(effect.high));
    CHECK(ms[1][1] == Approx(10.0));
    CHECK(dots[2][0] - dots[1][0] == Approx(2.0));  // A factor's name stands between.
  }
  CHECK(BlockOf(script, "accuracy0")[0][0] < BlockOf(script, "accuracy1")[0][0]);
  const ExperimentResults without = MadeUpResults();
  CHECK_FALSE(PlotEffects(MakeReport(without), folder.path()));
}

TEST_CASE("strata are drawn by their bins, a curve a row, without those that nothing is known of") {
  const TemporaryFolder folder;
  ExperimentResults results = MixedFactors();
  results.experiment.strata = {{Quantity::kInlierShare, {0.0, 0.2, 0.5}, {"good_few"}},
                               {Quantity::kBaseline, {1.0}, {}}};
  const Report report = MakeReport(results);
  CHECK(PlotStrata(report, report.strata[0], folder.path()) == HasGnuplot());
  const std::string script = ReadFile(folder.File("strata_inlier_share.gp"));
  const auto points = BlockOf(script, "strata_inlier_share0_0");
  REQUIRE(points.size() == 3);  // Nothing is below 0.
  CHECK(points[0][0] == 1.0);
  CHECK(points[2][1] == Approx(report.strata[0].strata[3].Of(report, results.cells[3]).mean));
  CHECK(BlockText(script, "strata_inlier_share0_1").empty());
  CHECK(script.find("\"≥ 0.5\\n6\" 3") != std::string::npos);
  CHECK_FALSE(PlotStrata(report, report.strata[1], folder.path()));
  WriteFileAtomically(folder.File("strata_points.png"), "of an earlier run");
  DrawFigures(report, folder.path());
  CHECK_FALSE(std::filesystem::exists(folder.File("strata_points.png")));
  CHECK(IsPng(folder.File("strata_inlier_share.png")) == HasGnuplot());
}

TEST_CASE(
    "of many rows twelve have a curve of strata, those that are compared and the best, in one colour in all panels") {
  ExperimentResults results = MixedFactors();
  results.experiment.compare = {{"more_6", "good_few"}};
  results.experiment.strata[0].bins = {0.5};
  for (std::size_t m = 6; m < 20; ++m) {
    results.experiment.methods.push_back(results.experiment.methods[0]);
    results.experiment.methods.back().label = results.experiment.methods.back().name = "more_" + std::to_string(m);
    results.cells.push_back(results.cells[0]);
    results.cells.back().method = m;
    for (ProblemRecord& record : results.cells.back().records)
      record.error.angle_deg = m % 2 == 0 ? 90.0 : 0.0;  // Seven are right everywhere.
  }
  const Report report = MakeReport(results);
  const std::vector<CurvePanel> panels = StrataPanels(report, report.strata[0]);
  REQUIRE(panels.size() == 2);
  REQUIRE(panels[0].curves.size() == 12);
  CHECK(std::count_if(panels[0].curves.begin(), panels[0].curves.end(),
                      [](const Curve& curve) { return curve.label.starts_with("more_"); }) == 8);  // more_6 is wrong.
  CHECK(panels[0].curves.back().label == "more_19");
  CHECK(panels[1].curves.size() == 4);  // The others did not run there.
  for (const Curve& curve : panels[1].curves) CHECK(panels[0].curves.at(curve.colour).label == curve.label);
}

TEST_CASE("nothing to draw is no picture") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpResults();
  results.cells.clear();
  CHECK_FALSE(PlotCurve(MakeReport(results), folder.path()));
  CHECK_FALSE(PlotBudget(MakeReport(results), folder.path()));
  results.experiment.figures.bars = {"first"};
  CHECK_FALSE(PlotBars(MakeReport(results), folder.path()));
  CHECK_FALSE(PlotFits(results, folder.path()));
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("text for gnuplot is quoted") { CHECK(GnuplotText("a \"b\" \\ c") == "\"a \\\"b\\\" \\\\ c\""); }

}  // namespace
}  // namespace diffsac
