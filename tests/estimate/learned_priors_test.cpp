// Whose probabilities weigh the points in a learned row's scores.

#include <torch/torch.h>

#include <catch2/catch.hpp>

#include "diffsac/estimate/diffsac_estimator.h"
#include "diffsac/problem/tasks.h"
#include "estimate/tiny_network.h"

namespace diffsac {
namespace {

/// The score of the same sets under weights of the network that are all `weight`.
double ScoreWith(PriorSource source, const Example& example, float weight) {
  DiffsacOptions options;
  options.num_diffusion_samples = 6;
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
  const DiffsacEstimator method(TinyNetwork(Task::kLine), options, 1);
  return method.EstimateFrom(NormalizedProblem(example.problem), prediction, 3).score;
}

}  // namespace

TEST_CASE("points count by the network, by the ratio or by both") {
  Example example = TinyExamples(Task::kLine, 1)[0];
  example.problem.snn_ratio = Eigen::VectorXd::Constant(example.problem.points.rows(), 0.5);
  const double network = ScoreWith(PriorSource::kNetwork, example, 0.4f);
  CHECK(network > 0.0);
  CHECK(ScoreWith(PriorSource::kNetwork, example, 0.8f) == Approx(2.0 * network));
  const double ratio = ScoreWith(PriorSource::kRatio, example, 0.4f);
  CHECK(ScoreWith(PriorSource::kRatio, example, 0.8f) == ratio);
  CHECK(ScoreWith(PriorSource::kBoth, example, 0.4f) == Approx(std::sqrt(network * ratio)));
  // Without a ratio the network's count where nothing else was asked for; otherwise points count alike.
  example.problem.snn_ratio.resize(0);
  CHECK(ScoreWith(PriorSource::kNetwork, example, 0.4f) == Approx(network));
  for (const PriorSource source : {PriorSource::kRatio, PriorSource::kBoth}) {
    CHECK(ScoreWith(source, example, 0.4f) == Approx(network / 0.4));
    CHECK(ScoreWith(source, example, 0.8f) == Approx(network / 0.4));
  }
}

TEST_CASE("the inlier head's sets are drawn by the network, by the ratio or by both") {
  const auto sets = [](PriorSource source, const Example& example, bool reversed) {
    DiffsacOptions options;
    options.num_diffusion_samples = 0;
    options.num_guided_samples = 20;
    options.selection = SetSelection::kGumbel;
    options.draws_by = source;
    Prediction prediction;
    const auto points = static_cast<std::size_t>(example.problem.points.rows());
    for (std::size_t i = 0; i < points; ++i) prediction.weights.push_back((i < points / 2) != reversed ? 0.9f : 1e-6f);
    const DiffsacEstimator method(TinyNetwork(Task::kLine), options, 1);
    return method.EstimateFrom(NormalizedProblem(example.problem), prediction, 3).minimal_sets;
  };
  Example example = TinyExamples(Task::kLine, 1)[0];
  const auto points = static_cast<int>(example.problem.points.rows());
  example.problem.snn_ratio.resize(points);
  for (int i = 0; i < points; ++i) example.problem.snn_ratio[i] = i % 2 == 0 ? 0.3 : 1.0;
  const auto share = [&](const auto& drawn, auto&& fits) {
    int count = 0, all = 0;
    for (const auto& set : drawn)
      for (const int point : set) {
        count += fits(point);
        ++all;
      }
    return static_cast<double>(count) / all;
  };
  const auto first_half = [&](int point) { return point < points / 2; };
  const auto even = [](int point) { return point % 2 == 0; };
  CHECK(share(sets(PriorSource::kNetwork, example, false), first_half) == 1.0);
  CHECK(sets(PriorSource::kRatio, example, false) == sets(PriorSource::kRatio, example, true));
  CHECK(share(sets(PriorSource::kRatio, example, false), even) > 0.9);
  const auto both = sets(PriorSource::kBoth, example, false);
  CHECK(share(both, first_half) > 0.95);
  CHECK(share(both, even) > 0.8);
  // Without a ratio the network says all.
  example.problem.snn_ratio.resize(0);
  CHECK(sets(PriorSource::kBoth, example, false) == sets(PriorSource::kNetwork, example, false));
}

}  // namespace diffsac
