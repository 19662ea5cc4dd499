#include <torch/torch.h>

#include <catch2/catch.hpp>

#include <set>

#include "diffsac/problem/tasks.h"
#include "estimate/tiny_network.h"
#include "lab/torch/ng_ransac.h"
#include "lab/torch/weighted_estimator.h"

namespace diffsac {
namespace {

// Sets that were solved: a line's set has one solution, and nothing else is solved or fitted.
int Draws(const LearnedEstimator& method, const Example& example, const Prediction& prediction) {
  return method.EstimateFrom(NormalizedProblem(example.problem), prediction, 3).stats.hypotheses;
}

DiffsacOptions Options() {
  DiffsacOptions options;
  options.num_diffusion_samples = 6;
  options.sampler.steps = 2;
  options.consensus.refit = Refit::kNone;
  return options;
}

DiffsacOptions ByConfidence(double confidence, int max_iterations) {
  DiffsacOptions options = Options();
  options.consensus.stopping = Stopping::kConfidence;
  options.consensus.confidence = confidence;
  options.consensus.max_iterations = max_iterations;
  return options;
}

// As of a network that knows nothing: with a high confidence the search needs many sets.
Prediction Flat(const Example& example, int copies) {
  Prediction prediction;
  const auto points = static_cast<std::size_t>(example.problem.points.rows());
  Rng rng(2);
  for (std::size_t i = 0; i < copies * points; ++i)
    prediction.confidences.push_back(static_cast<float>(rng.Uniform(-0.1, 0.1)));
  prediction.weights.assign(points, 0.5f);
  return prediction;
}

Prediction Perfect(const Example& example, int copies) {
  Prediction prediction = Flat(example, copies);
  const auto points = static_cast<std::size_t>(example.problem.points.rows());
  for (std::size_t i = 0; i < prediction.confidences.size(); ++i)
    prediction.confidences[i] += example.truth.inliers[i % points] ? 0.8f : -0.8f;
  for (std::size_t i = 0; i < points; ++i) prediction.weights[i] = example.truth.inliers[i] ? 0.9f : 0.1f;
  return prediction;
}

}  // namespace

TEST_CASE("a learned row takes exactly its own sets, whatever the consensus' limits for the other rule say") {
  const auto example = TinyExamples(Task::kLine, 1)[0];
  const auto network = TinyNetwork(Task::kLine);
  auto options = Options();
  options.selection = SetSelection::kGumbel;
  options.consensus.max_iterations = 3;
  CHECK(Draws(DiffsacEstimator(network, options, 1), example, Flat(example, 6)) == 6);
  options.num_guided_samples = 4;
  CHECK(Draws(DiffsacEstimator(network, options, 1), example, Flat(example, 6)) == 10);
  options.num_uniform_samples = 5;
  CHECK(Draws(DiffsacEstimator(network, options, 1), example, Flat(example, 6)) == 15);
  options.num_diffusion_samples = 0;
  CHECK(Draws(DiffsacEstimator(network, options, 1), example, Flat(example, 6)) == 9);
}

TEST_CASE("a learned search ends when it is confident, and else goes on up to the limit") {
  const auto example = TinyExamples(Task::kLine, 1, 0.2)[0];
  const auto network = TinyNetwork(Task::kLine);
  auto options = ByConfidence(0.5, 1000);
  CHECK(Draws(DiffsacEstimator(network, options, 1), example, Perfect(example, 6)) < 6);
  options.consensus.min_iterations = 4;
  CHECK(Draws(DiffsacEstimator(network, options, 1), example, Perfect(example, 6)) >= 4);
  const auto hard = TinyExamples(Task::kLine, 1, 0.9)[0];
  // The last of the sources goes on: the copies, the inlier head or the extra source.
  for (const auto selection : {SetSelection::kMaximum, SetSelection::kGumbel})
    for (const int head : {0, 2})
      for (const int extra : {0, 2}) {
        options = ByConfidence(1.0 - 1e-9, 40);
        options.selection = selection;
        options.num_guided_samples = head;
        options.num_uniform_samples = extra;
        CAPTURE(static_cast<int>(selection), head, extra);
        CHECK(Draws(DiffsacEstimator(network, options, 1), hard, Flat(hard, 6)) == 40);
        options.num_diffusion_samples = 0;
        options.num_guided_samples = 6;
        CHECK(Draws(DiffsacEstimator(network, options, 1), hard, Flat(hard, 6)) == 40);
      }
}

TEST_CASE("the sets of a search by confidence begin as those of a budget") {
  const auto example = TinyExamples(Task::kLine, 1, 0.9)[0];
  const auto network = TinyNetwork(Task::kLine);
  auto budget = Options(), search = ByConfidence(1.0 - 1e-9, 100);
  for (auto* options : {&budget, &search}) {
    options->selection = SetSelection::kGumbel;
    options->num_guided_samples = 4;
    options->num_uniform_samples = 5;
  }
  const auto prediction = Flat(example, 6);
  const NormalizedProblem space(example.problem);
  const auto a = DiffsacEstimator(network, budget, 1).EstimateFrom(space, prediction, 3).minimal_sets;
  const auto b = DiffsacEstimator(network, search, 1).EstimateFrom(space, prediction, 3).minimal_sets;
  REQUIRE(a.size() == 15);
  REQUIRE(b.size() == 20);
  CHECK(std::equal(a.begin(), a.end(), b.begin()));
}

TEST_CASE("copies that go on take the predictions of earlier steps next") {
  const auto example = TinyExamples(Task::kLine, 1, 0.9)[0];
  auto options = ByConfidence(1.0 - 1e-9, 7);
  // One copy whose earlier step points elsewhere.
  options.num_diffusion_samples = 1;
  Prediction prediction = Flat(example, 2);
  const auto points = static_cast<std::size_t>(example.problem.points.rows());
  prediction.confidences.assign(2 * points, -1.0f);
  prediction.confidences[3] = prediction.confidences[5] = 1.0f;
  prediction.confidences[points + 8] = prediction.confidences[points + 9] = 1.0f;
  const auto sets = DiffsacEstimator(TinyNetwork(Task::kLine), options, 1)
                        .EstimateFrom(NormalizedProblem(example.problem), prediction, 3)
                        .minimal_sets;
  REQUIRE(sets.size() == 7);
  CHECK(sets[0] == std::vector<int>{3, 5});
  CHECK(sets[1] == std::vector<int>{8, 9});
}

TEST_CASE("rows of learned weights take their hypotheses, fewer when they are confident") {
  const auto example = TinyExamples(Task::kLine, 1, 0.2)[0];
  NgRansacNetworkOptions network;
  network.features.kinds = {PointFeature::kCoordinates};
  network.width = 8;
  network.blocks = 1;
  const auto weights = MakeLearnedWeights<NgRansacNetwork>(Task::kLine, network, Rng(1));
  WeightedEstimatorOptions options;
  options.consensus.refit = Refit::kNone;
  options.max_iterations = 12;
  CHECK(Draws(WeightedEstimator(weights, options, 1), example, Perfect(example, 0)) == 12);
  options.consensus.stopping = Stopping::kConfidence;
  options.consensus.confidence = 0.5;
  CHECK(Draws(WeightedEstimator(weights, options, 1), example, Perfect(example, 0)) < 12);
  options.consensus.confidence = 1.0 - 1e-9;
  CHECK(Draws(WeightedEstimator(weights, options, 1), example, Flat(example, 0)) == 12);
  options.max_iterations = 0;
  options.weighted_fit = true;
  CHECK(Draws(WeightedEstimator(weights, options, 1), example, Perfect(example, 0)) == 1);
}

}  // namespace diffsac
