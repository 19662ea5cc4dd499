// A whole configuration of diffsac_eval: YAML, in which lines "#--set KEY=VALUE" are what the command line adds, read
// as the program does up to where data and networks are opened.

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "fuzz/fuzz_target.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/eval/experiment.h"
#include "lab/eval/sweep.h"

namespace diffsac::testing {

std::vector<std::string> Seeds() {
  std::vector<std::string> seeds = SeedFiles("config");
  // With what they include, which stays behind.
  for (const auto& entry : std::filesystem::directory_iterator(DIFFSAC_SOURCE_DIR "/configs/tables"))
    seeds.push_back(ToYaml(ConfigFromFile(entry.path().string())));
  std::sort(seeds.begin(), seeds.end());
  return seeds;
}

namespace {

constexpr const char* kName = "fuzz.yaml";

Config ReadConfig(const std::string& text) {
  Config config = ConfigFromYaml(text, kName);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("#--set ")) SetYaml(&config, line.substr(7));
  return config;
}

void ReadAll(const std::string& text) {
  const Config config = ReadConfig(text);
  Require(ToYaml(ConfigFromYaml(ToYaml(config))) == ToYaml(config), "what is written reads back");
  const auto axes = SweepAxes(config);
  const ExperimentOptions experiment = ReadExperiment(WithoutSweepAxes(config));
  // Rows and data throw by themselves, so that one that is wrong does not hide the others.
  for (const Condition& condition : experiment.conditions)
    Parses({kName, "--set"}, [&] { WriteDatasetOptions(condition.data); });
  for (const EstimatorRow& row : experiment.methods)
    Parses({}, [&] { ResolvedRow(row.config, experiment.task, EstimatorContext{}); });
}

}  // namespace
}  // namespace diffsac::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diffsac::testing;
  const std::string text(reinterpret_cast<const char*>(data), size);
  Parses({kName, "--set"}, [&] { ReadAll(text); });
  return 0;
}
