// Where the time of one image pair goes: milliseconds of features, network and consensus on one pair, beside classical
// rows that are run in turn with it, round after round. Figures are medians over rounds, ratios are taken within a
// round, so that they hold on a machine whose speed drifts; the least total and the processor's time say what other
// programs took. Memory is the process's peak during a call of its own.
//
//   diffsac_stages [--task fundamental] [--checkpoint models/fundamental/model.safetensors] [--points 200,500,2000]
//                  [--threads 1,2] [--rounds 15] [--rows learned_prosac]
#include <torch/torch.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lab/config/dataset_factory.h"
#include "lab/config/make_estimator.h"
#include "lab/config/run_directory.h"
#include "lab/config/yaml.h"
#include "measure.h"

namespace diffsac {
namespace {

constexpr int kPairs = 4;  // Rounds take these in turn.

struct Options {
  std::string task = "fundamental";
  std::string checkpoint;
  std::string device = "cpu";
  std::vector<int> points = {200, 500, 2000};
  std::vector<int> threads = {1, 2};
  std::string rows;  // only those that this occurs in
  int rounds = 15;
  int copies = 20;
};

// One row of the table and what was measured of it.
struct Row {
  std::string name;
  std::shared_ptr<RobustEstimator> method;
  std::vector<double> features = {}, network = {}, consensus = {}, total = {}, processor = {}, ratio = {};
  double peak_mib = 0.0;
};

std::vector<Problem> MakePairs(const Options& options, int points) {
  const std::string yaml = "{type: synthetic_two_view, task: " + options.task +
                           ", split: benchmark, num_points: " + std::to_string(points) + ", outlier_ratio: 0.5}";
  const auto dataset = MakeDataset(ConfigFromYaml(yaml, "benchmark"), 1);
  std::vector<Problem> pairs;
  for (int i = 0; i < kPairs; ++i) pairs.push_back(dataset->Get(i).problem);
  return pairs;
}

// What is measured: a name and the keys of a row. The first is what the others are compared with. "inlier head" runs
// features, encoder and consensus alone: its network time is the encoder's. "LibTorch, all points" is what was before
// the fused network, on every point.
std::vector<std::pair<std::string, std::string>> RowKeys(const Options& options) {
  const std::string consensus =
      "consensus: {score: msac, local_optimization: lo_ransac, refit: iterated, refit_rounds: 5, "
      "refit_threshold_factor: 1.2, final_score: msac, final_refinement: lm}";
  const std::string diffsac = "{type: diffsac, checkpoint: '" + options.checkpoint + "', selection: gumbel, " +
                              "temperature: [0.2, 1], " + consensus;
  const std::string recommended = "{type: diffsac, preset: recommended, checkpoint: '" + options.checkpoint + "'";
  const std::string copies =
      ", num_guided_samples: 0, num_diffusion_samples: " + std::to_string(options.num_diffusion_samples);
  const std::string twenty =
      diffsac + ", num_diffusion_samples: 10, num_guided_samples: 10, max_decoded_points: 128, sampler: {steps: 1}";
  return {
      {"PROSAC 1000", "{type: prosac, max_iterations: 1000}"},
      {"PROSAC 20", "{type: prosac, max_iterations: 20}"},
      {"LO-RANSAC 1000", "{type: lo_ransac, max_iterations: 1000}"},
      {"OpenCV USAC_ACCURATE 1000", "{type: usac, preset: accurate, max_iterations: 1000}"},
      {"inlier head, no reverse step", diffsac + ", num_diffusion_samples: 0, num_guided_samples: " +
                                           std::to_string(options.num_diffusion_samples) + ", max_encoded_points: 0}"},
      {"20 sets: 10 copies, 1 step, 128 decoded, head 10; LibTorch, all points",
       twenty + ", engine: libtorch, max_encoded_points: 0}"},
      {"20 sets, all points", twenty + ", max_encoded_points: 0}"},
      {"20 sets, 512 points encoded", twenty + ", max_encoded_points: 512}"},
      {"DiffSAC, 2 steps, 128 decoded", diffsac + copies + ", max_decoded_points: 128, sampler: {steps: 2}}"},
      {"DiffSAC, 2 steps, all decoded", diffsac + copies + ", max_decoded_points: 0, sampler: {steps: 2}}"},
      // What diffsac_pair runs, and as it was before.
      {"learned_prosac", recommended + "}"},
      {"learned_prosac; LibTorch, all points", recommended + ", engine: libtorch, max_encoded_points: 0}"}};
}

std::vector<Row> MakeRows(const Options& options, int threads) {
  EstimatorContext context;
  context.threads = threads;
  context.device = options.device;
  std::vector<Row> rows;
  const auto wanted = [&](const std::string& name) {
    return rows.empty() || name.find(options.rows) != std::string::npos;
  };
  for (const auto& [name, keys] : RowKeys(options)) {
    if (!wanted(name)) continue;
    rows.push_back({name, MakeEstimator(ConfigFromYaml(keys, "benchmark"), TaskFromString(options.task), context)});
  }
  return rows;
}

void RunOnce(const Problem& pair, std::uint64_t seed, Row* row) {
  const std::clock_t start = std::clock();
  const EstimationStats report = row->method->Run(pair, seed).stats;
  row->processor.push_back(1000.0 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  row->features.push_back(report.ms_features);
  row->network.push_back(report.ms_network);
  row->consensus.push_back(report.ms_consensus);
  row->total.push_back(report.ms_total);
}

void Measure(const std::vector<Problem>& pairs, int rounds, std::vector<Row>* rows) {
  for (Row& row : *rows) row.method->Run(pairs[0], 0);  // Caches and allocators, not measured.
  for (int round = 0; round < rounds; ++round) {
    const Problem& pair = pairs[round % pairs.size()];
    for (Row& row : *rows) RunOnce(pair, round, &row);
    for (Row& row : *rows) row.ratio.push_back(row.total.back() / rows->front().total.back());
  }
  for (Row& row : *rows) {
    ResetPeak();
    row.method->Run(pairs[0], 0);
    row.peak_mib = MemoryMiB("VmHWM");
  }
}

void Print(int points, int threads, double before_mib, const std::vector<Row>& rows) {
  std::printf("\n### N = %d, %d thread(s); before any row runs the process holds %.0f MiB\n\n", points, threads,
              before_mib);
  std::printf(
      "| row | features | network | consensus | total | least total | processor | per second | / PROSAC 1000 | peak, "
      "MiB |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : rows) {
    const double total = Median(row.total);
    std::printf("| %s | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.3g | %.3g | %.0f |\n", row.name.c_str(),
                Median(row.features), Median(row.network), Median(row.consensus), total,
                *std::min_element(row.total.begin(), row.total.end()), Median(row.processor), 1000.0 / total,
                Median(row.ratio), row.peak_mib);
  }
  std::fflush(stdout);
}

void Run(const Options& options) {
  std::printf("%s\n%s\n%s, κ = %d, half of the matches wrong, milliseconds, medians of %d rounds\n",
              VersionText("diffsac_stages").c_str(), MachineText().c_str(), options.checkpoint.c_str(),
              options.num_diffusion_samples, options.rounds);
  for (const int points : options.points) {
    const std::vector<Problem> pairs = MakePairs(options, points);
    for (const int threads : options.threads) {
      torch::set_num_threads(threads);
      std::vector<Row> rows = MakeRows(options, threads);
      const double before_mib = MemoryMiB("VmRSS");
      Measure(pairs, options.rounds, &rows);
      Print(points, threads, before_mib, rows);
    }
  }
}

}  // namespace
}  // namespace diffsac

int main(int argc, char** argv) {
  CLI::App app{"Time by stage of one image pair"};
  diffsac::Options options;
  app.add_option("--task", options.task, "fundamental, essential or homography");
  app.add_option("--checkpoint", options.checkpoint, "A model of the task (default: models/<task>/model.safetensors)");
  app.add_option("--device", options.device, "auto, cpu or cuda");
  app.add_option("--points", options.points, "Numbers of matches")->delimiter(',')->check(CLI::PositiveNumber);
  app.add_option("--threads", options.threads, "Thread counts")->delimiter(',')->check(CLI::PositiveNumber);
  app.add_option("--rows", options.rows, "Only rows that this occurs in, and the first");
  app.add_option("--rounds", options.rounds, "Rounds; figures are medians")->check(CLI::PositiveNumber);
  app.add_option("--copies", options.num_diffusion_samples, "κ")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  if (options.checkpoint.empty()) options.checkpoint = "models/" + options.task + "/model.safetensors";
  try {
    diffsac::Run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "diffsac_stages: %s\n", error.what());
    return 2;
  }
  return 0;
}
