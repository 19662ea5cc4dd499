#include "lab/eval/example_files.h"

#include <H5Cpp.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "lab/eval/eval_fixtures.h"
#include "lab/eval/runner.h"
#include "lab/files/hdf5_input.h"

namespace diffsac {
namespace {

using namespace testing;

nlohmann::json JsonIn(const std::string& path) {
  const H5::DataSet data = OpenHdf5(path).openDataSet("json");
  std::string text(static_cast<std::size_t>(data.getSpace().getSimpleExtentNpoints()), '\0');
  data.read(text.data(), H5::PredType::NATIVE_UINT8);
  return nlohmann::json::parse(text);
}

ExperimentResults RunOf(const std::string& yaml) {
  return RunExperiment(
      ReadExperiment(ConfigFromYaml(yaml, "examples.yaml")),
      {[](const Config& row, Task task) { return MakeRow(row, task, EstimatorContext{}); }, {}, nullptr, {}});
}

const std::string kPairs =
    "name: pairs\ntask: fundamental\nproblems: 6\n"
    "data: {type: synthetic_two_view, task: fundamental, num_points: 60}\n"
    "methods:\n  exact: {type: ransac, label: RANSAC, max_iterations: 50}\n"
    "figures: {qualitative: 1}\n";

}  // namespace

TEST_CASE("the names of a pair's images are the example's, or stand in its id") {
  Example example;
  example.id = "scene/a-b";
  CHECK(ImageNames(example) == std::pair<std::string, std::string>{"a", "b"});
  example.image1 = "x-1";
  example.image2 = "y";
  CHECK(ImageNames(example) == std::pair<std::string, std::string>{"x-1", "y"});
  CHECK(ImageNames(Example()) == std::pair<std::string, std::string>{});
}

TEST_CASE("of too many errors the largest, the smallest and some between are kept") {
  std::vector<double> errors;
  for (int i = 0; i < 100; ++i) errors.push_back((i * 37) % 100);
  errors[5] = std::nan("");
  const std::vector<std::size_t> chosen = LargestSmallestAndSpread(errors, 8);
  REQUIRE(chosen.size() == 8);
  CHECK(std::is_sorted(chosen.begin(), chosen.end()));
  std::multiset<double> kept;
  for (const std::size_t i : chosen) kept.insert(std::isnan(errors[i]) ? -1.0 : errors[i]);
  for (const double value : {99.0, 98.0, 97.0, 96.0, -1.0, 0.0}) CHECK(kept.count(value) == 1);
  CHECK(LargestSmallestAndSpread(errors, 100).size() == 100);
}

TEST_CASE("a run's fits and pairs are there with their points, and go with the next run that has none") {
  const TemporaryFolder folder;
  ExperimentResults results = RunOf(kPairs);
  WriteFits(results, folder.path());
  WritePairs(results, folder.path());
  const nlohmann::json fits = JsonIn(folder.File(kFitsFile)), pairs = JsonIn(folder.File(kPairsFile));
  REQUIRE(fits["fits"].size() == 1);
  CHECK(fits["fits"][0]["inliers"].size() == 60);
  CHECK(fits["fits"][0]["status"] == "ok");
  REQUIRE(pairs["examples"].size() == 6);
  CHECK(pairs["examples"][5]["name"] == results.cells[0].records[5].id);
  const H5::H5File file = OpenHdf5(folder.File(kPairsFile));
  CHECK(file.openDataSet("points-5").getSpace().getSimpleExtentNpoints() == 240);
  CHECK(file.openDataSet("inliers-5").getSpace().getSimpleExtentNpoints() == 60);
  // Without estimates only the kept fits can be drawn.
  results.experiment.estimates = false;
  WritePairs(results, folder.path());
  CHECK(JsonIn(folder.File(kPairsFile))["examples"].size() == 1);
  results.fits.clear();
  results.experiment.report = false;
  WriteFits(results, folder.path());
  WritePairs(results, folder.path());
  CHECK_FALSE(std::filesystem::exists(folder.File(kFitsFile)));
  CHECK_FALSE(std::filesystem::exists(folder.File(kPairsFile)));
}

}  // namespace diffsac
