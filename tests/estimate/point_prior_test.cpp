#include "diffsac/estimate/point_prior.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/estimate/encoded_points.h"
#include "diffsac/estimate/estimation_priors.h"
#include "diffsac/problem/match_probabilities.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"

namespace diffsac {
namespace {

Example Pair() {
  return MakeDataset(ConfigFromYaml("{type: synthetic_two_view, task: fundamental, num_points: 400, outlier_ratio: "
                                    "0.6}"),
                     3)
      ->Get(0);
}

double ShareOfInliers(const std::vector<int>& rows, const std::vector<std::uint8_t>& inliers) {
  double sum = 0.0;
  for (const int i : rows) sum += inliers[i];
  return sum / static_cast<double>(rows.size());
}

}  // namespace

TEST_CASE("the neighbourhood finds inliers where the ratio says nothing") {
  Example example = Pair();
  example.problem.snn_ratio.setConstant(0.8);
  const NormalizedProblem space(example.problem);
  PointFeaturesOptions options;
  options.kinds = {PointFeature::kRatio};
  const PointFeatures ratio(options, Task::kFundamental);
  options.kinds = {PointFeature::kRatio, PointFeature::kNeighborhood};
  const PointFeatures both(options, Task::kFundamental);
  const auto by_ratio = PointPrior(space, ratio.Compute(space, Rng(1)), ratio);
  const auto by_both = PointPrior(space, both.Compute(space, Rng(1)), both);
  CHECK(by_ratio[7] == Approx(InlierProbabilityOfRatio(example.problem.snn_ratio[7])));
  CHECK((by_both.minCoeff() >= 0.0f && by_both.maxCoeff() <= 1.0f));
  const auto& inliers = example.truth.inliers;
  CHECK(ShareOfInliers(LikeliestPoints(by_both, 100), inliers) >
        ShareOfInliers(LikeliestPoints(by_ratio, 100), inliers) + 0.2);
}

TEST_CASE("points of a plane are likely by the hypotheses that they agree with") {
  const auto example =
      MakeDataset(ConfigFromYaml("{type: synthetic_plane, num_points: 300, outlier_ratio: 0.5}"), 3)->Get(0);
  const NormalizedProblem space(example.problem);
  PointFeaturesOptions options;
  options.kinds = {PointFeature::kCoordinates, PointFeature::kResidual};
  const PointFeatures features(options, Task::kPlane);
  const auto prior = PointPrior(space, features.Compute(space, Rng(1)), features);
  CHECK(ShareOfInliers(LikeliestPoints(prior, 75), example.truth.inliers) > 0.85);
  options.kinds = {PointFeature::kCoordinates};
  const PointFeatures none(options, Task::kPlane);
  CHECK(PointPrior(space, none.Compute(space, Rng(1)), none) == Eigen::VectorXf::Constant(300, 0.5f));
}

TEST_CASE("the likeliest points come in their order, the first of those that tie") {
  Eigen::VectorXf prior(6);
  prior << 0.1f, 0.9f, 0.5f, 0.5f, 0.5f, 0.8f;
  CHECK(LikeliestPoints(prior, 3) == std::vector<int>{1, 2, 5});
  CHECK(LikeliestPoints(prior, 6) == std::vector<int>{0, 1, 2, 3, 4, 5});
  CHECK(LikeliestPoints(prior, 60).size() == 6);
}

TEST_CASE("points that the network was not shown weigh by their prior and have no confidence") {
  FeatureSet features;
  features.values.resize(4, 1);
  features.values << 1.0f, 2.0f, 3.0f, 4.0f;
  Eigen::VectorXf prior(4);
  prior << 0.8f, 0.1f, 0.2f, 0.6f;
  EncodedPoints encoded;
  CHECK_FALSE(encoded.chosen());
  encoded.Choose(prior, 2, features);
  REQUIRE(encoded.chosen());
  CHECK(encoded.features().values(1, 0) == 4.0f);
  Denoised said;
  said.weights = {0.5f, 0.2f};
  said.confidences = {0.1f, 0.2f, 0.3f, 0.4f};  // two copies
  said.steps = {{1.0f, 2.0f, 3.0f, 4.0f}};
  encoded.GiveToAll(&said);
  const float scale = 0.7f / 1.4f, none = -std::numeric_limits<float>::infinity();
  REQUIRE(said.weights.size() == 4);
  CHECK(said.weights[0] == 0.5f);
  CHECK(said.weights[1] == Approx(scale * 0.1f));
  CHECK(said.weights[3] == 0.2f);
  CHECK(said.confidences == std::vector<float>{0.1f, none, none, 0.2f, 0.3f, none, none, 0.4f});
  CHECK(said.steps[0] == std::vector<float>{1.0f, none, none, 2.0f, 3.0f, none, none, 4.0f});
}

}  // namespace diffsac
