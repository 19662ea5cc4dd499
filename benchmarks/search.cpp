// Milliseconds of the processor's time of the search alone, without a network and without LibTorch: classical rows and
// the recommended settings on one thread, on random pairs with half of the matches wrong or on pairs from files. Rows
// are run in turn, round after round; figures are medians over rounds. Stages are told apart by rows that leave the
// later ones out.
//
//   diffsac_search [--tasks fundamental,essential,homography] [--points 200,500,2000,8000,100000] [--rounds 15]
//                  [--pairs FOLDER] [--stages] [--row 0]

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/estimate/presets.h"
#include "diffsac/problem/normalized_problem.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/sample_consensus.h"
#include "diffsac/ransac/samplers/prosac_sampler.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "measure.h"

namespace diffsac {
namespace {

struct Options {
  int row = -1;  ///< Only this one, counted from 0.
  std::vector<std::string> tasks = {"fundamental", "essential", "homography"};
  std::vector<int> points = {200, 500, 2000, 8000, 100000};
  std::string pairs;
  int num_pairs = 4;  ///< Rounds take these in turn.
  int rounds = 16;
  bool stages = false;
};

struct Row {
  std::string name;
  ConsensusOptions consensus;
  bool by_quality = true;
  std::vector<double> milliseconds = {};
  double inliers = 0.0, draws = 0.0, fits = 0.0;  ///< Sums over rounds.
};

/// MSAC, inner samples, five refits and Levenberg-Marquardt: what the rows `prosac` and `lo_ransac` are.
ConsensusOptions Local(int draws) {
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMsac;
  options.local_optimization = LocalOptimization::kInnerSamples;
  options.refit = Refit::kIterated;
  options.refit_rounds = 5;
  options.refit_threshold_factor = 1.2;
  options.final_refinement = FinalRefinement::kRefinement;
  options.max_iterations = draws;
  return options;
}

/// The recommended search, until confident or all draws.
ConsensusOptions Recommended(Task task, int draws, Stopping stopping) {
  ConsensusOptions options = RecommendedClassical(task).consensus;
  options.max_iterations = draws;
  options.stopping = stopping;
  if (stopping == Stopping::kBudget) options.min_iterations = 0;
  return options;
}

std::vector<Row> MakeRows(Task task, bool stages) {
  std::vector<Row> rows;
  rows.push_back({"PROSAC 1000", Local(1000)});
  rows.push_back({"PROSAC 20", Local(20)});
  rows.push_back({"LO-RANSAC 1000", Local(1000), false});
  rows.push_back({"recommended, 1000 draws", Recommended(task, 1000, Stopping::kBudget)});
  rows.push_back({"recommended, until confident", Recommended(task, 1000, Stopping::kConfidence)});
  if (!stages) return rows;
  for (const int base : {0, 3}) {
    ConsensusOptions options = rows[base].consensus;
    const std::string name = rows[base].name;
    if (options.num_finalists > 0) {
      options.num_finalists = 0;
      rows.push_back({name + ", all candidates refined to the end", options});
    }
    options.final_refinement = FinalRefinement::kNone;
    rows.push_back({name + ", less LM", options});
    options.refit = Refit::kNone;
    rows.push_back({name + ", less LM, refits", options});
    options.local_optimization = LocalOptimization::kNone;
    rows.push_back({name + ", less LM, refits, LO", options});
  }
  return rows;
}

template <MinimalModel Model>
ConsensusResult Search(const Problem& problem, const NormalizedProblem& space, const Row& row, int seed) {
  EstimationPriors priors;
  priors.unit = space.unit();
  // The better half of the ratios is likelier right; any such probabilities do here.
  if (row.consensus.inlier_prior_power > 0.0)
    priors.inlier_priors = (1.0 - 0.8 * problem.snn_ratio.array().min(1.0).max(0.0)).matrix();
  const Rng rng(seed);
  const std::vector<double> quality(problem.snn_ratio.data(), problem.snn_ratio.data() + problem.snn_ratio.size());
  std::unique_ptr<MinimalSampler> source;
  if (row.by_quality) {
    source = std::make_unique<ProsacSampler>(quality, Model::kMinimalSize, rng);
  } else {
    source = std::make_unique<UniformSampler>(static_cast<int>(space.points().rows()), Model::kMinimalSize, rng);
  }
  return SampleConsensus<Model>(space.points(), space.threshold(), *source, row.consensus, rng, priors);
}

void RunOnce(const Problem& problem, int seed, Row* row) {
  const std::clock_t start = std::clock();
  const NormalizedProblem space(problem);
  const ConsensusResult result =
      DispatchTask(problem.task, [&]<MinimalModel Model>() { return Search<Model>(problem, space, *row, seed); });
  row->milliseconds.push_back(1000.0 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  row->inliers += static_cast<double>(std::count(result.inliers.begin(), result.inliers.end(), 1));
  row->draws += static_cast<double>(result.iterations);
  row->fits += result.hypotheses;
}

/// Round by round, so that they hold on a machine whose speed drifts.
std::vector<double> Ratios(const Row& row, const Row& first) {
  std::vector<double> ratios = row.milliseconds;
  for (std::size_t i = 0; i < ratios.size(); ++i) ratios[i] /= first.milliseconds[i];
  return ratios;
}

void Measure(const std::string& title, const std::vector<Problem>& problems, const Options& options) {
  std::vector<Row> rows = MakeRows(problems.front().task, options.stages);
  if (options.row >= 0) rows = {rows.at(options.row)};
  for (int round = 0; round < options.rounds; ++round)
    for (Row& row : rows) RunOnce(problems[round % problems.size()], round, &row);
  std::printf(
      "\n### %s\n\n| row | ms | least | / first row | inliers | draws | models |\n|---|---|---|---|---|---|---|\n",
      title.c_str());
  for (const Row& row : rows)
    std::printf("| %s | %.3g | %.3g | %.3g | %.1f | %.0f | %.0f |\n", row.name.c_str(), Median(row.milliseconds),
                *std::min_element(row.milliseconds.begin(), row.milliseconds.end()), Median(Ratios(row, rows.front())),
                row.inliers / options.rounds, row.draws / options.rounds, row.fits / options.rounds);
  std::fflush(stdout);
}

std::vector<Problem> Read(const std::string& yaml, int count) {
  const auto dataset = MakeDataset(ConfigFromYaml(yaml, "benchmark"), 1);
  std::vector<Problem> problems;
  for (int i = 0; i < count && i != dataset->size(); ++i) problems.push_back(dataset->Get(i).problem);
  return problems;
}

void Run(const Options& options) {
  for (const std::string& task : options.tasks) {
    if (!options.pairs.empty()) {
      const std::string yaml =
          "{type: correspondences, task: " + task + ", paths: ['" + options.pairs + "'], max_pairs: 4}";
      Measure(task + ", " + options.pairs, Read(yaml, options.rounds), options);
      continue;
    }
    for (const int points : options.points) {
      const std::string yaml = "{type: synthetic_two_view, split: benchmark, outlier_ratio: 0.5, task: " + task +
                               ", num_points: " + std::to_string(points) + "}";
      Measure(task + ", N = " + std::to_string(points), Read(yaml, options.num_pairs), options);
    }
  }
}

}  // namespace
}  // namespace diffsac

int main(int argc, char** argv) {
  CLI::App app{"Time of the search without a network"};
  diffsac::Options options;
  app.add_option("--tasks", options.tasks, "Two-view tasks")->delimiter(',');
  app.add_option("--points", options.points, "Numbers of matches")->delimiter(',')->check(CLI::PositiveNumber);
  app.add_option("--pairs", options.pairs, "Pairs from the files of this folder instead");
  app.add_option("--rounds", options.rounds, "Rounds; figures are medians")->check(CLI::PositiveNumber);
  app.add_option("--row", options.row, "Only the row of this place, from 0, for a profile");
  app.add_flag("--stages", options.stages, "Also rows that leave out later stages");
  CLI11_PARSE(app, argc, argv);
  try {
    diffsac::Run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "diffsac_search: %s\n", error.what());
    return 2;
  }
  return 0;
}
