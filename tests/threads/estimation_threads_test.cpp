// The search, the data and the evaluation on several threads.

#include <catch2/catch.hpp>
#include <thread>
#include <vector>

#include "core/temporary_folder.h"
#include "diffsac/core/parallel.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/hyperplane.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/sample_consensus.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/data/two_view_test_util.h"
#include "lab/eval/run_files.h"
#include "lab/eval/runner.h"

namespace diffsac {
namespace {

template <MinimalModel Model>
ConsensusResult Search(const PointMatrix& points, double threshold, const ConsensusOptions& options, int threads) {
  UniformSampler source(static_cast<int>(points.rows()), Model::kMinimalSize, Rng(1));
  return SampleConsensus<Model>(points, threshold, source, options, Rng(2), {}, threads);
}

template <MinimalModel Model>
void CheckThreads(const Example& example) {
  for (const LocalOptimization local :
       {LocalOptimization::kInnerSamples, LocalOptimization::kGraphCut, LocalOptimization::kRefinement}) {
    ConsensusOptions options;
    options.score = options.final_score = ScoreKind::kMsac;
    options.local_optimization = local;
    options.refit = Refit::kIterated;
    options.stopping = Stopping::kConfidence;
    options.max_iterations = 400;
    const auto one = Search<Model>(example.problem.points, example.problem.inlier_threshold, options, 1);
    const auto more = Search<Model>(example.problem.points, example.problem.inlier_threshold, options, 0);
    CHECK(one.model == more.model);
    CHECK(one.hypotheses == more.hypotheses);
  }
}

std::unique_ptr<Dataset> Data(const std::string& options) {
  return MakeDataset(ConfigFromYaml("{" + options + "}"), 1);
}

}  // namespace

TEST_CASE("the search on several threads") {
  CheckThreads<Line>(Data("type: synthetic_line, num_points: 200, outlier_ratio: 0.5")->Get(0));
  CheckThreads<Fundamental>(
      Data("type: synthetic_two_view, task: fundamental, num_points: 200, outlier_ratio: 0.4")->Get(0));
}

TEST_CASE("generated data and correspondence files are read by several threads at once") {
  TemporaryFolder folder;
  WriteCorrespondences(folder / "kitti_00_step_01", SyntheticSet(4, 40, Rng(1)));
  WriteCorrespondences(folder / "kitti_01_step_01", SyntheticSet(4, 40, Rng(2)));
  const auto generated = Data("type: synthetic_two_view, task: essential, num_points: 60");
  const auto files = Data("type: kitti, task: essential, root: " + folder.path());
  for (const Dataset* data : {generated.get(), files.get()}) {
    std::vector<std::thread> threads;
    std::vector<double> sums(4);
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        for (std::uint64_t i = 0; i < 24; ++i) sums[t] += data->Get(i % 8).problem.points.sum();
      });
    for (std::thread& thread : threads) thread.join();
    for (const double sum : sums) CHECK(sum == sums[0]);
  }
}

TEST_CASE("an evaluation on several threads: classical rows, a network, an interruption") {
  const std::string network = std::string(DIFFSAC_SOURCE_DIR) + "/models/line/model.safetensors";
  ExperimentOptions experiment = ReadExperiment(ConfigFromYaml(R"(
name: threads
task: line
seed: 3
problems: 24
data: {type: synthetic_line, num_points: 60, split: test, outlier_ratio: 0.4}
methods:
  - {type: lo_ransac, max_iterations: 50}
  - {type: prosac, max_iterations: 50}
  - {type: dgsac, max_iterations: 60}
  - {type: oracle}
  - {type: diffsac, checkpoint: )" + network + R"(, num_diffusion_samples: 4, batch: 4}
)"));
  const auto run = [&](int threads, const std::atomic<bool>* stop) {
    experiment.threads = threads;
    EstimatorContext context;
    context.threads = threads;
    return RunExperiment(experiment,
                         {[&](const Config& row, Task task) { return MakeRow(row, task, context); }, {}, stop});
  };
  const auto one = run(1, nullptr), all = run(0, nullptr);
  REQUIRE(one.cells.size() == all.cells.size());
  for (std::size_t c = 0; c < one.cells.size(); ++c)
    for (std::size_t i = 0; i < one.cells[c].records.size(); ++i) {
      CHECK(one.cells[c].records[i].error.angle_deg == all.cells[c].records[i].error.angle_deg);
      CHECK(one.cells[c].records[i].stats.hypotheses == all.cells[c].records[i].stats.hypotheses);
    }
  // Another thread says stop, as a signal does.
  std::atomic<bool> stop{false};
  std::thread interrupt([&] { stop = true; });
  const auto partial = run(0, &stop);
  interrupt.join();
  CHECK(partial.cells.size() <= one.cells.size());
}

}  // namespace diffsac
