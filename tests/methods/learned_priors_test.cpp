// Whose probabilities weigh the points in a learned row's scores.

#include <torch/torch.h>

#include <catch2/catch.hpp>

#include "diffsac/data/tasks.h"
#include "diffsac/methods/diffsac_method.h"
#include "methods/tiny_network.h"

namespace diffsac {
namespace {

/// The score of the same sets under weights of the network that are all `weight`.
double ScoreWith(PriorSource source, const Example& example, float weight) {
  DiffsacOptions options;
  options.copies = 6;
  options.consensus.score = options.consensus.final_score = ScoreKind::kMsac;
  options.consensus.refit = Refit::kNone;
  options.consensus.inlier_prior_power = 1.0;
  options.inlier_prior_of = source;
  Prediction prediction;
  const auto points = static_cast<std::size_t>(example.problem.points.rows());
  Rng rng(2);
  for (std::size_t i = 0; i < 6 * points; ++i)
    prediction.confidences.push_back(static_cast<float>(rng.Uniform(-0.1, 0.1)));
  prediction.weights.assign(points, weight);
  const DiffsacMethod method(TinyNetwork(Task::kLine), options, 1);
  return method.EstimateFrom(SolverSpace(example.problem), prediction, 3).score;
}

}  // namespace

TEST_CASE("points count by the network, by the ratio or by both") {
  Example example = TinyExamples(Task::kLine, 1)[0];
  example.problem.quality = Eigen::VectorXd::Constant(example.problem.points.rows(), 0.5);
  const double network = ScoreWith(PriorSource::kNetwork, example, 0.4f);
  CHECK(network > 0.0);
  CHECK(ScoreWith(PriorSource::kNetwork, example, 0.8f) == Approx(2.0 * network));
  const double ratio = ScoreWith(PriorSource::kRatio, example, 0.4f);
  CHECK(ScoreWith(PriorSource::kRatio, example, 0.8f) == ratio);
  CHECK(ScoreWith(PriorSource::kBoth, example, 0.4f) == Approx(std::sqrt(network * ratio)));
  // Without a ratio the network's are all there is.
  example.problem.quality.resize(0);
  CHECK(ScoreWith(PriorSource::kRatio, example, 0.4f) == Approx(network));
}

}  // namespace diffsac
