// Rows whose network is asked only where the sets before it were not enough, and is shown some of the points.

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "diffsac/data/dataset_factory.h"
#include "diffsac/data/tasks.h"
#include "methods/make_row.h"

namespace diffsac {
namespace {

const std::string kCheckpoint = "checkpoint: '" DIFFSAC_SOURCE_DIR "/models/fundamental/model.safetensors'";
const std::string kHead = "guide: inlier_head, head_sets: 0, max_decoded_points: 0, copies: 300, selection: gumbel";

std::unique_ptr<Method> Row(const std::string& more) {
  return MakeRow("diffsac", Task::kFundamental, "{" + kCheckpoint + ", " + kHead + ", " + more + "}");
}

Example Pair(double outliers) {
  return MakeDataset(
             Config::FromString("{type: synthetic_two_view, task: fundamental, num_points: 500, outlier_ratio: " +
                                std::to_string(outliers) + "}"),
             5)
      ->Get(0);
}

const std::string kConfident = "consensus: {stopping: confidence, max_iterations: 500}";

}  // namespace

TEST_CASE("a pair that PROSAC's first sets are enough for asks no network, a hard one does") {
  const auto row = Row("first_sets: 192, " + kConfident);
  const Estimate easy = row->Estimate(Pair(0.15).problem, 1);
  REQUIRE(easy.status == Status::kOk);
  CHECK(easy.report.ms_denoise == 0.0);
  CHECK(easy.inlier_probabilities.empty());
  CHECK(easy.report.draws <= 192);
  const Estimate hard = row->Estimate(Pair(0.75).problem, 1);
  CHECK(hard.report.ms_denoise > 0.0);
  CHECK(hard.inlier_probabilities.size() == 500);
  CHECK(hard.report.draws > 192);
  CHECK(hard.report.ms_total >= hard.report.ms_consensus + hard.report.ms_denoise);
}

TEST_CASE("what asks the network from the start cannot go with first sets") {
  CHECK_THROWS_WITH(Row("first_sets: 64, consensus: {stopping: budget}"), Catch::Contains("first_sets"));
  CHECK_THROWS_WITH(
      Row("first_sets: 64, inlier_prior_of: network, consensus: {stopping: confidence, inlier_prior_power: 1}"),
      Catch::Contains("first_sets"));
  CHECK_NOTHROW(
      Row("first_sets: 64, inlier_prior_of: ratio, consensus: {stopping: confidence, inlier_prior_power: 1}"));
}

TEST_CASE("a batch of lazy rows estimates as one by one, on any number of threads") {
  MethodContext context;
  std::vector<Example> examples = {Pair(0.2), Pair(0.6), Pair(0.75)};
  std::vector<const Problem*> problems;
  for (const Example& example : examples) problems.push_back(&example.problem);
  problems.push_back(problems.front());
  const Problem nothing;
  problems.push_back(&nothing);
  const std::vector<std::uint64_t> all_seeds = {1, 2, 3, 4, 5};
  for (const std::string& keys : std::vector<std::string>{"first_sets: 64, " + kConfident, kConfident,
                                                          "max_encoded_points: 100, " + kConfident}) {
    for (const int threads : {1, 3}) {
      context.threads = threads;
      Config config = Config::FromString("{type: diffsac, " + kCheckpoint + ", " + kHead + ", " + keys + "}");
      const auto row = MakeMethod(config, Task::kFundamental, context);
      const auto together = row->EstimateBatch(problems, all_seeds);
      for (std::size_t i = 0; i < problems.size(); ++i) {
        const Estimate alone = row->Estimate(*problems[i], all_seeds[i]);
        CHECK(together[i].status == alone.status);
        CHECK(together[i].model == alone.model);
        CHECK(together[i].inliers == alone.inliers);
      }
    }
  }
}

TEST_CASE("a network that is shown more points than there are is shown all") {
  const Example example = Pair(0.5);
  const Estimate all = Row("max_encoded_points: 0, " + kConfident)->Estimate(example.problem, 1);
  const Estimate more = Row("max_encoded_points: 501, " + kConfident)->Estimate(example.problem, 1);
  CHECK(all.inlier_probabilities == more.inlier_probabilities);
  const Estimate some = Row("max_encoded_points: 100, " + kConfident)->Estimate(example.problem, 1);
  CHECK(some.inlier_probabilities.size() == 500);
  CHECK(some.inlier_probabilities != all.inlier_probabilities);
  CHECK_THROWS_WITH(Row("max_encoded_points: 6, " + kConfident), Catch::Contains("max_encoded_points"));
}

}  // namespace diffsac
