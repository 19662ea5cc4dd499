#include <torch/torch.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "estimate/make_estimator.h"
#include "estimate/tiny_network.h"
#include "lab/baselines/oracle.h"
#include "lab/data/plane_pair.h"
#include "lab/data/synthetic.h"

namespace diffsac {
namespace {

constexpr const char* kSearches[] = {"sequential", "at_once"};

Example Lines(int instances, std::uint64_t index = 0) {
  SyntheticInstancesOptions options;
  options.instances = {instances, 1.0};
  return MakeSyntheticInstances(options, 8)->Get(index);
}

std::string Keys(const std::string& search) {
  return "{max_iterations: 300, instances: {search: " + search +
         "}, consensus: {score: msac, refit: iterated, refit_rounds: 2, final_score: msac}}";
}

void CheckWhole(const Estimate& estimate, const Problem& problem) {
  REQUIRE(estimate.status == Status::kOk);
  REQUIRE(!estimate.instances.empty());
  CHECK(estimate.model == estimate.instances.front());
  const auto count = static_cast<std::size_t>(problem.points.rows());
  REQUIRE(estimate.assignment.size() == count);
  REQUIRE(estimate.inliers.size() == count);
  for (std::size_t i = 0; i < count; ++i) {
    CHECK((estimate.assignment[i] > 0) == (estimate.inliers[i] != 0));
    CHECK(estimate.assignment[i] <= static_cast<std::int32_t>(estimate.instances.size()));
  }
}

}  // namespace

TEST_CASE("rows that do not learn find several lines, each in its own way") {
  for (const char* search : kSearches)
    for (const char* type : {"ransac", "lo_ransac", "magsac_pp"}) {
      CAPTURE(search, type);
      const Example example = Lines(3);
      const Estimate estimate = MakeRow(type, Task::kLine, Keys(search))->Run(example.problem, 1);
      CheckWhole(estimate, example.problem);
      CHECK(estimate.instances.size() == 3);
      CHECK(estimate.stats.iterations >= 300);
    }
}

TEST_CASE("rows that do not learn find several planes of two views, PROSAC by the ratios of what is left") {
  int found = 0;
  for (int i = 0; i < 5; ++i) {
    const Example example = testing::PlanePair({80, 80}, 40, i);
    const Estimate estimate =
        MakeRow("prosac", Task::kHomography, "{max_iterations: 500, instances: {search: sequential}}")
            ->Run(example.problem, 1);
    CheckWhole(estimate, example.problem);
    found += static_cast<int>(estimate.instances.size());
  }
  CHECK(found >= 8);
}

TEST_CASE("a learned row looks for several structures at once and one after the other, with its network's sets") {
  const auto network = TinyNetwork(Task::kLine);
  for (const InstanceSearch search : {InstanceSearch::kAtOnce, InstanceSearch::kSequential})
    for (const int copies : {30, 0}) {
      CAPTURE(ToString(search), copies);
      DiffsacOptions options;
      options.num_diffusion_samples = copies;
      options.num_guided_samples = 30 - copies;
      options.sampler.steps = 2;
      options.num_uniform_samples = 200;
      options.feature_hypotheses = true;
      options.instances.search = search;
      const DiffsacEstimator method(network, options, 1);
      const Example example = Lines(2);
      const Estimate estimate = method.Run(example.problem, 3);
      CheckWhole(estimate, example.problem);
      CHECK(estimate.instances.size() == 2);
      CHECK(estimate.inlier_probabilities.size() == static_cast<std::size_t>(example.problem.points.rows()));
      for (const auto& set : estimate.minimal_sets)
        for (const int point : set) CHECK((point >= 0 && point < example.problem.points.rows()));
      const Problem* problems[] = {&example.problem, &example.problem};
      const std::uint64_t seeds[] = {3, 3};
      CHECK(method.RunBatch(problems, seeds)[1].assignment == estimate.assignment);
    }
}

TEST_CASE("a network that relates points decodes only the likeliest of them") {
  NetworkOptions network = TinyOptions();
  network.denoiser.relation = true;
  DiffsacOptions options;
  options.sampler.steps = 2;
  options.max_decoded_points = 30;
  options.instances.search = InstanceSearch::kAtOnce;
  const Example example = Lines(1);
  const Estimate estimate = DiffsacEstimator(TinyNetwork(Task::kLine, network), options, 1).Run(example.problem, 3);
  CHECK(estimate.stats.iterations == options.num_diffusion_samples);
}

TEST_CASE("what cannot hold a structure gives a status and an empty list, for every search") {
  Problem nothing = Lines(1).problem, noise = nothing, bad = nothing;
  nothing.points.conservativeResize(1, 2);
  bad.points.col(1).setConstant(std::numeric_limits<double>::quiet_NaN());
  Rng rng(4);
  for (double& value : noise.points.reshaped()) value = rng.Uniform(0.0, 10.0);
  for (const char* search : kSearches) {
    CAPTURE(search);
    const auto row = MakeRow("ransac", Task::kLine, Keys(search));
    CHECK(row->Run(nothing, 1).status == Status::kTooFewPoints);
    CHECK(row->Run(bad, 1).status != Status::kOk);
    const Estimate none = row->Run(noise, 1);
    CHECK((none.status == Status::kNoModel) == none.instances.empty());
    CHECK(none.instances.size() <= 1);
    for (const Problem* problem : {&nothing, &bad}) CHECK(row->Run(*problem, 1).instances.empty());
  }
}

TEST_CASE("the ceiling of several structures is each one's least squares") {
  const Example example = Lines(3);
  const Estimate estimate = OracleEstimate(example.problem, example.truth);
  CheckWhole(estimate, example.problem);
  CHECK(estimate.assignment == example.truth.assignment);
  CHECK(estimate.instances.size() == 3);
}

TEST_CASE("keys of several structures are refused where one is looked for") {
  CHECK_THROWS_WITH(MakeRow("ransac", Task::kLine, "{instances: {most: 3}}"),
                    Catch::Contains("another search than one"));
  CHECK_THROWS_WITH(MakeRow("ransac", Task::kLine, "{instances: {search: at_ones}}"), Catch::Contains("at_once"));
}

}  // namespace diffsac
