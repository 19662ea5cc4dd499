#include "diffsac/eval/plots.h"

#include <catch2/catch.hpp>

#include <filesystem>

#include "diffsac/core/files.h"
#include "diffsac/eval/gnuplot.h"
#include "eval/eval_fixtures.h"

namespace diffsac {
namespace {

using namespace testing;

bool IsPng(const std::string& path) {
  return std::filesystem::exists(path) && ReadFile(path).substr(0, 4) == "\x89PNG";
}

TEST_CASE("pictures are drawn where gnuplot is") {
  const TemporaryFolder folder;
  ExperimentOptions experiment = SmallExperiment();
  experiment.figures.budget = {{"Two points", {"first", "second"}}};
  ExperimentResults results = RunExperiment(experiment, TwoPointInputs());
  // These methods report no time, which is no place on a logarithmic axis.
  CHECK_FALSE(PlotTime(results, folder.path()));
  CHECK_FALSE(std::filesystem::exists(folder.File("time.gp")));
  for (Cell& cell : results.cells)
    for (ProblemRecord& record : cell.records) record.report.ms_total = 0.5;
  DrawFigures(results, folder.path());
  for (const char* name : {"curve", "budget", "time", "fits"}) {
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

TEST_CASE("nothing to draw is no picture") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpResults();
  results.cells.clear();
  CHECK_FALSE(PlotCurve(results, folder.path()));
  CHECK_FALSE(PlotBudget(results, folder.path()));
  CHECK_FALSE(PlotFits(results, folder.path()));
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("text for gnuplot is quoted") { CHECK(GnuplotText("a \"b\" \\ c") == "\"a \\\"b\\\" \\\\ c\""); }

}  // namespace
}  // namespace diffsac
