// Time of the point features on one thread, nanoseconds a match or point: least of several rounds. What is linear in N
// has the same figure in every column.
//
//   diffsac_features [N]...      defaults: 200 500 2000 8000 100000

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/problem/coordinates.h"
#include "diffsac/problem/good_neighbors.h"
#include "diffsac/problem/neighborhood_features.h"
#include "diffsac/problem/point_features.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"

namespace diffsac {
namespace {

/// Keeps the compiler from dropping what is measured.
volatile double sink = 0.0;

/// Seconds that one call takes: the least of seven, and of as many as fit into a third of a second.
double SecondsPerCall(const std::function<double()>& call) {
  using Clock = std::chrono::steady_clock;
  double least = 1e300, sum = 0.0;
  for (int run = 0; run < 7 || sum < 0.3; ++run) {
    const auto start = Clock::now();
    sink = sink + call();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    least = std::min(least, seconds);
    sum += seconds;
  }
  return least;
}

Problem MakeProblem(const std::string& type, const std::string& task, int count) {
  const std::string yaml = "{type: " + type + (task.empty() ? "" : ", task: " + task) +
                           ", num_points: " + std::to_string(count) + ", outlier_ratio: 0.5}";
  return MakeDataset(ConfigFromYaml(yaml, "benchmark"), 1)->Get(0).problem;
}

/// Matches of which nine in ten lie on a hundredth of the picture.
PointMatrix Clustered(PointMatrix points) {
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (i % 10 != 0) points.row(i) *= 0.1;
  return points;
}

/// All at one place in image 1.
PointMatrix Stacked(PointMatrix points) {
  points.leftCols(2).setZero();
  return points;
}

/// One match far away, which takes most of the bounding box.
PointMatrix WithOutlier(PointMatrix points) {
  points.row(0) *= 1e6;
  return points;
}

using Measure = std::function<double(int count)>;

/// Seconds that the features of one task's problem take.
Measure FeaturesOf(const std::string& type, const std::string& task, std::vector<PointFeature> kinds,
                   ResidualChoice choice = ResidualChoice::kBest) {
  return [=](int count) {
    const Problem problem = MakeProblem(type, task, count);
    const NormalizedProblem space(problem);
    PointFeaturesOptions options;
    options.kinds = kinds;
    options.residual_choice = choice;
    const PointFeatures features(options, problem.task);
    return SecondsPerCall([&] { return static_cast<double>(features.Compute(space, Rng(1)).values(0, 0)); });
  };
}

Measure Neighborhood(PointMatrix (*change)(PointMatrix)) {
  return [=](int count) {
    const Problem problem = MakeProblem("synthetic_two_view", "fundamental", count);
    const PointMatrix points = change(MatchCoordinates(problem));
    return SecondsPerCall([&] {
      return static_cast<double>(NeighborhoodFeatures(points, FindGoodNeighbors(points, problem.snn_ratio))(0, 0));
    });
  };
}

void Run(const std::vector<int>& counts) {
  using enum PointFeature;
  const std::vector<std::pair<const char*, Measure>> rows = {
      {"neighborhood", Neighborhood([](PointMatrix points) { return points; })},
      {"neighborhood, clustered", Neighborhood(&Clustered)},
      {"neighborhood, image 1 in one place", Neighborhood(&Stacked)},
      {"neighborhood, one far away", Neighborhood(&WithOutlier)},
      {"F: coordinates, ratio", FeaturesOf("synthetic_two_view", "fundamental", {kRatio})},
      {"F: coordinates, ratio, neighborhood", FeaturesOf("synthetic_two_view", "fundamental", {kRatio, kNeighborhood})},
      {"lines: coordinates, residual", FeaturesOf("synthetic_line", "", {kCoordinates, kResidual})},
      {"planes: coordinates, residual", FeaturesOf("synthetic_plane", "", {kCoordinates, kResidual})},
      {"planes: the same, spread",
       FeaturesOf("synthetic_plane", "", {kCoordinates, kResidual}, ResidualChoice::kSpread)},
      {"H: coordinates, residual", FeaturesOf("synthetic_two_view", "homography", {kCoordinates, kResidual})},
  };
  std::printf("| features, ns a point |");
  for (const int count : counts) std::printf(" N = %d |", count);
  std::printf("\n|---|");
  for (std::size_t i = 0; i < counts.size(); ++i) std::printf("---|");
  std::printf("\n");
  for (const auto& [name, measure] : rows) {
    std::printf("| %s |", name);
    for (const int count : counts) std::printf(" %.0f |", 1e9 * measure(count) / count), std::fflush(stdout);
    std::printf("\n");
  }
}

}  // namespace
}  // namespace diffsac

int main(int argc, char** argv) {
  std::vector<int> counts;
  for (int i = 1; i < argc; ++i) counts.push_back(std::max(1, std::atoi(argv[i])));
  if (counts.empty()) counts = {200, 500, 2000, 8000, 100000};
  try {
    diffsac::Run(counts);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "diffsac_features: %s\n", error.what());
    return 2;
  }
  return 0;
}
