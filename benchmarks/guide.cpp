// The estimator that ships, without LibTorch, as the number of matches grows: milliseconds of features, network and
// consensus, and the memory that a process needs beyond its data. What diffsac_pair runs with and without guidance, and
// OpenCV, in turn, round after round; medians.
//
//   diffsac_guide_benchmark [--task fundamental] [--points 500,2000,8000,32000,100000] [--rounds 7] [--csv FILE]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/make_estimator.h"
#include "lab/config/run_directory.h"
#include "lab/config/yaml.h"
#include "measure.h"

namespace diffsac {
namespace {

struct Options {
  std::string task = "fundamental";
  std::vector<int> points = {500, 2000, 8000, 32000, 100000};
  int rounds = 7;
  std::string csv;
};

// OpenCV 4.6's USAC_ACCURATE overflows its stack at 100 000 matches.
constexpr int kMostOfOpencv = 50000;

struct Row {
  std::string name;
  bool opencv;
  std::unique_ptr<RobustEstimator> method;
};

std::vector<Problem> MakePairs(const Options& options, int points) {
  const std::string yaml = "{type: synthetic_two_view, task: " + options.task +
                           ", split: benchmark, num_points: " + std::to_string(points) + ", outlier_ratio: 0.5}";
  const auto dataset = MakeDataset(ConfigFromYaml(yaml, "benchmark"), 1);
  std::vector<Problem> pairs;
  for (int i = 0; i < 3; ++i) pairs.push_back(dataset->Get(i).problem);
  return pairs;
}

std::vector<Row> MakeRows(const Options& options) {
  EstimatorContext context;
  context.threads = 1;
  std::vector<Row> rows;
  const std::string network = "models/" + options.task + "/model.safetensors}";
  for (const auto& [name, keys] : std::vector<std::pair<std::string, std::string>>{
           {"learned_prosac", "{type: diffsac, preset: recommended, checkpoint: " + network},
           {"prosac_marginalised", "{type: prosac, preset: recommended, consensus: {stopping: budget}}"},
           {"usac", "{type: usac, preset: accurate, max_iterations: 1000}"}})
    rows.push_back({name, name == "usac",
                    MakeEstimator(ConfigFromYaml(keys, "benchmark"), TaskFromString(options.task), context)});
  return rows;
}

void Measure(const Options& options, std::vector<Row>& rows, std::ofstream* csv) {
  std::printf(
      "\n| N | row | features | network | consensus | total | µs a match | beyond the data, MiB "
      "|\n|---|---|---|---|---|---|---|---|\n");
  for (const int points : options.points) {
    if (points > kMostOfOpencv) std::erase_if(rows, [](const Row& row) { return row.opencv; });
    const std::vector<Problem> pairs = MakePairs(options, points);
    std::vector<std::vector<EstimationStats>> reports(rows.size());
    std::vector<double> memory;
    for (Row& row : rows) {
      ResetPeak();
      const double before = MemoryMiB("VmRSS");
      row.method->Run(pairs[0], 0);
      memory.push_back(MemoryMiB("VmHWM") - before);
    }
    for (int round = 0; round < options.rounds; ++round)
      for (std::size_t r = 0; r < rows.size(); ++r)
        reports[r].push_back(rows[r].method->Run(pairs[round % pairs.size()], round).stats);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const auto median = [&](double EstimationStats::*field) {
        std::vector<double> values;
        for (const EstimationStats& report : reports[r]) values.push_back(report.*field);
        return Median(values);
      };
      const double total = median(&EstimationStats::ms_total);
      std::printf("| %d | %s | %.2f | %.2f | %.2f | %.2f | %.2f | %.1f |\n", points, rows[r].name.c_str(),
                  median(&EstimationStats::ms_features), median(&EstimationStats::ms_network),
                  median(&EstimationStats::ms_consensus), total, 1000.0 * total / points, memory[r]);
      if (csv->is_open()) *csv << points << ',' << rows[r].name << ',' << total << '\n';
    }
    std::fflush(stdout);
  }
}

void Run(const Options& options) {
  const double start = MemoryMiB("VmRSS");
  std::vector<Row> rows = MakeRows(options);
  std::printf("%s\n%s\n%s, half of the matches wrong, one thread, milliseconds, medians of %d rounds\n",
              VersionText("diffsac_guide_benchmark").c_str(), MachineText().c_str(), options.task.c_str(),
              options.rounds);
  std::printf("at start the process holds %.0f MiB, with rows and network %.0f MiB\n", start, MemoryMiB("VmRSS"));
  std::ofstream csv;
  if (!options.csv.empty()) csv.open(options.csv);
  Measure(options, rows, &csv);
}

}  // namespace
}  // namespace diffsac

int main(int argc, char** argv) {
  CLI::App app{"The shipped estimator by number of matches, without LibTorch"};
  diffsac::Options options;
  app.add_option("--task", options.task, "fundamental, essential or homography");
  app.add_option("--points", options.points, "Numbers of matches")->delimiter(',')->check(CLI::PositiveNumber);
  app.add_option("--rounds", options.rounds, "Rounds; figures are medians")->check(CLI::PositiveNumber);
  app.add_option("--csv", options.csv, "Also N,row,milliseconds into this file");
  CLI11_PARSE(app, argc, argv);
  try {
    diffsac::Run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "diffsac_guide_benchmark: %s\n", error.what());
    return 2;
  }
  return 0;
}
