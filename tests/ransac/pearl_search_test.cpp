#include "diffsac/ransac/instances/pearl_search.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/hyperplane.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"

namespace diffsac {
namespace {

constexpr double kThreshold = 3.0;

PointMatrix Uniform(int count, int columns, double side, Rng rng) {
  PointMatrix points(count, columns);
  for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = rng.Uniform(0.0, side);
  return points;
}

struct Scene {
  PointMatrix points;
  std::vector<std::int32_t> labels;
};

// Two planes side by side that move differently, with noise of half a pixel, and wrong matches.
Scene TwoPlanes(int of_each, int wrong, std::uint64_t seed) {
  Rng rng(seed);
  Scene scene{Uniform(2 * of_each + wrong, 4, 600.0, rng.Fork("all")), {}};
  const Eigen::Matrix3d planes[] = {Eigen::Matrix3d{{1.0, 0.05, 20.0}, {-0.03, 1.1, -10.0}, {1e-4, 0.0, 1.0}},
                                    Eigen::Matrix3d{{0.8, 0.0, 160.0}, {0.1, 0.9, 40.0}, {0.0, -1e-4, 1.0}}};
  for (int i = 0; i < scene.points.rows(); ++i) {
    const int plane = i / of_each;
    scene.labels.push_back(plane < 2 ? plane + 1 : 0);
    if (plane >= 2) continue;
    auto match = scene.points.row(i);
    match[0] = 0.5 * match[0] + 300.0 * plane;
    const Eigen::Vector3d there = planes[plane] * Eigen::Vector3d(match[0], match[1], 1.0);
    match[2] = there[0] / there[2] + 0.5 * rng.Normal();
    match[3] = there[1] / there[2] + 0.5 * rng.Normal();
  }
  return scene;
}

template <class Model>
InstancesResult Find(const PointMatrix& points, double threshold, InstanceSearchOptions instances = {}) {
  instances.search = InstanceSearch::kPearl;
  instances.rounds = 4;
  ConsensusOptions options;
  options.max_iterations = 400;
  MinimalSamplerOptions sampling;
  sampling.sampler = MinimalSamplerKind::kNapsac;
  const SamplerOfRows sampler = [&](const std::vector<int>& rows, int number) {
    return MakeMinimalSampler(sampling, points(rows, Eigen::all), Model::kMinimalSize, Rng(7).Fork("search", number),
                              {}, {});
  };
  return FindInstances<Model>(points, threshold, sampler, options, instances, Rng(3));
}

int Wrong(const Scene& scene, const InstancesResult& found, bool swapped) {
  int wrong = 0;
  for (std::size_t i = 0; i < scene.labels.size(); ++i) {
    const std::int32_t label = scene.labels[i];
    wrong += found.assignment[i] != (swapped && label > 0 ? 3 - label : label);
  }
  return wrong;
}

TEST_CASE("An expansion is the best of all in which some points take the label") {
  constexpr int kPoints = 10;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Rng rng(seed);
    const PointMatrix points = Uniform(kPoints, 2, 1.0, rng.Fork("points"));
    const Eigen::VectorXd outlier = Eigen::VectorXd::NullaryExpr(kPoints, [&] { return rng.Uniform(); });
    LabelEnergy::ModelCosts costs(3);
    for (auto& cost : costs) cost = Eigen::VectorXd::NullaryExpr(kPoints, [&] { return rng.Uniform(); });
    LabelEnergy::Labels labels;
    for (int i = 0; i < kPoints; ++i) labels.push_back(static_cast<std::int32_t>(rng.Below(4)));
    const LabelEnergy energy(points, 3, 0.05 * static_cast<double>(seed % 5), 0.0, outlier);
    for (std::int32_t label = 0; label <= 3; ++label) {
      double least = std::numeric_limits<double>::infinity();
      for (int code = 0; code < 1 << kPoints; ++code) {
        LabelEnergy::Labels moved = labels;
        for (int i = 0; i < kPoints; ++i) moved[i] = code >> i & 1 ? label : moved[i];
        least = std::min(least, energy.Value(costs, moved));
      }
      LabelEnergy::Labels moved = labels;
      energy.Expand(costs, label, &moved);
      CHECK(energy.Value(costs, moved) == Approx(least).margin(1e-5));
    }
    LabelEnergy::Labels all = labels;
    const double before = energy.Value(costs, labels), after = energy.ExpandAll(costs, &all);
    CHECK(after <= before);
    CHECK(after == Approx(energy.Value(costs, all)));
  }
}

TEST_CASE("The energy counts outliers, models in use and neighbours that differ") {
  PointMatrix points(3, 1);
  points << 0.0, 1.0, 2.5;  // Edges 0-1 and 1-2.
  const LabelEnergy energy(points, 1, 0.5, 4.0, Eigen::Vector3d(1.0, 2.0, 3.0));
  const LabelEnergy::ModelCosts costs = {Eigen::Vector3d(0.1, 0.2, 0.3), Eigen::Vector3d(0.4, 0.5, 0.6)};
  CHECK(energy.Value(costs, {0, 0, 0}) == Approx(6.0));
  CHECK(energy.Value(costs, {1, 1, 0}) == Approx(0.3 + 3.0 + 4.0 + 0.5));
  CHECK(energy.Value(costs, {1, 2, 1}) == Approx(0.1 + 0.5 + 0.3 + 8.0 + 1.0));
}

TEST_CASE("Neighbours speak for right matches and against wrong ones, of too few matches they say nothing") {
  const Scene scene = TwoPlanes(80, 80, 1);
  const Eigen::VectorXd support = NeighborhoodSupport(scene.points, 10);
  int right = 0;
  for (int i = 0; i < support.size(); ++i) right += (support[i] > 0.0) == (scene.labels[i] > 0);
  CHECK(right >= 0.95 * static_cast<double>(support.size()));
  CHECK(NeighborhoodSupport(scene.points.topRows(19), 10).isZero());
}

TEST_CASE("Two planes of an image pair are found with their matches, alike each time") {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Scene scene = TwoPlanes(60, 80, seed);
    const InstancesResult found = Find<Homography>(scene.points, kThreshold);
    REQUIRE(found.status == Status::kOk);
    REQUIRE(found.models.size() == 2);
    CHECK(std::min(Wrong(scene, found, false), Wrong(scene, found, true)) <= 6);
    CHECK(found.hypotheses > 400);
    CHECK(found.iterations == 400);
    const InstancesResult again = Find<Homography>(scene.points, kThreshold);
    CHECK(again.assignment == found.assignment);
    CHECK(again.models == found.models);
  }
}

TEST_CASE("No point is given to a model farther away than the reach, and sizes fall") {
  InstanceSearchOptions instances;
  instances.reach = 2.0;
  const Scene scene = TwoPlanes(60, 80, 9);
  const InstancesResult found = Find<Homography>(scene.points, kThreshold, instances);
  REQUIRE(found.models.size() == 2);
  std::vector<int> sizes(3, 0);
  for (int i = 0; i < scene.points.rows(); ++i) {
    const std::int32_t label = found.assignment[i];
    ++sizes[label];
    if (label == 0) continue;
    const Homography::Parameters model = found.models[label - 1];
    CHECK(Homography::Residual(model, scene.points.data() + 4 * i) <= 2.0 * kThreshold);
  }
  CHECK(sizes[1] >= sizes[2]);
}

TEST_CASE("Wrong matches alone, too few points and a structure's cost beyond all points give none") {
  CHECK(Find<Homography>(Uniform(150, 4, 600.0, Rng(5)), kThreshold).status == Status::kNoModel);
  CHECK(Find<Homography>(Uniform(3, 4, 600.0, Rng(5)), kThreshold).status == Status::kTooFewPoints);
  CHECK(Find<Homography>(Uniform(6, 4, 600.0, Rng(5)), kThreshold).models.empty());
  InstanceSearchOptions instances;
  instances.instance_cost = 1e5;
  const InstancesResult none = Find<Homography>(TwoPlanes(60, 20, 1).points, kThreshold, instances);
  CHECK(none.status == Status::kNoModel);
  CHECK(std::count(none.assignment.begin(), none.assignment.end(), 0) == 140);
  instances.instance_cost = 5.0;
  instances.most = 1;
  CHECK(Find<Homography>(TwoPlanes(60, 20, 1).points, kThreshold, instances).models.size() == 1);
}

TEST_CASE("Lines, which have no matches' neighbours, are found by the same energy") {
  Rng rng(2);
  PointMatrix points = Uniform(150, 2, 10.0, rng.Fork("all"));
  for (int i = 0; i < 100; ++i)
    points(i, 1) = (i < 50 ? 1.0 + 0.7 * points(i, 0) : 9.0 - 0.8 * points(i, 0)) + 0.03 * rng.Normal();
  InstanceSearchOptions instances;
  instances.reach = 2.0;
  instances.spatial_weight = 0.0;
  const InstancesResult found = Find<Line>(points, 0.1, instances);
  REQUIRE(found.models.size() == 2);
  for (const ModelParameters& model : found.models) {
    const double slope = -model[0] / model[1];
    CHECK(std::min(std::abs(slope - 0.7), std::abs(slope + 0.8)) < 0.03);
  }
}

}  // namespace
}  // namespace diffsac
