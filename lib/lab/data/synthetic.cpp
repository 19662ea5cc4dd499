#include "lab/data/synthetic.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/synthetic_points.h"

namespace diffsac {
namespace {

// A Gaussian value around `centre`, drawn again until it lies inside the box (coordinates are independent).
double ClusterCoordinate(double centre, double sigma, Rng& rng) {
  for (;;) {
    const double value = centre + sigma * rng.Normal();
    if (value >= 0.0 && value <= kBoxSide) return value;
  }
}

template <class Point>
void AppendAggregated(const SyntheticOptions& options, int count, Rng rng, std::vector<Point>* points) {
  std::vector<Point> centres;
  AppendUniform(options.clusters, rng.Fork("centres"), &centres);
  for (int i = 0; i < count; ++i) {
    Point p = centres[rng.Below(centres.size())];
    for (double& value : p) value = ClusterCoordinate(value, options.cluster_sigma, rng);
    points->push_back(p);
  }
}

// One dataset for both tasks; Section is LineSection or PlaneSection.
template <class Section>
class SyntheticDataset : public GeneratedDataset {
 public:
  static constexpr int kDimension = Section::kDimension;
  static constexpr Task kTask = kDimension == 2 ? Task::kLine : Task::kPlane;

  SyntheticDataset(const SyntheticOptions& options, std::uint64_t seed)
      : GeneratedDataset(options, "synthetic_" + ToString(kTask) + "/" + options.split,
                         ToString(kTask) + "/" + options.split + "/", seed),
        options_(options) {}

  Task task() const override { return kTask; }

 private:
  Example Draw(std::uint64_t /*index*/, const Rng& rng) const override {
    // A stream for each purpose: changing the noise, say, leaves the models and the outliers as they were.
    const auto [total, inliers] = DrawCounts(options_.num_points, options_.outlier_ratio, kTask, rng.Fork("counts"));
    Rng models = rng.Fork("model"), outliers = rng.Fork("outliers");
    const Section section = DrawSection<Section>(options_.model_sampling, options_.min_extent, models);
    const NoiseSource noise(options_.noise, options_.sigma, options_.inlier_threshold, rng.Fork("noise"));
    std::vector<PointOf<Section>> points;
    points.reserve(total);
    AppendOnSection(section, inliers, noise, rng.Fork("inliers"), &points);
    if (options_.outliers == OutlierKind::kAggregated)
      AppendAggregated(options_, total - inliers, outliers, &points);
    else
      AppendUniform(total - inliers, outliers, &points);
    std::vector<std::int32_t> labels(inliers, 1);
    labels.resize(points.size(), 0);

    Example example;
    example.problem.task = kTask;
    example.problem.inlier_threshold = options_.inlier_threshold;
    SetShuffled(points, labels, rng.Fork("shuffle"), &example);
    GroundTruth& truth = example.truth;
    truth.inliers.assign(truth.assignment.begin(), truth.assignment.end());
    truth.assignment.clear();
    truth.model = ParametersOf(section);
    return example;
  }

  SyntheticOptions options_;
};

}  // namespace

void SyntheticOptions::Bind(OptionsBinder& b) {
  b.Field("num_points", num_points, Within(3, 1e7)).Help("points of a problem");
  b.Field("outlier_ratio", outlier_ratio, Within(0.0, 1.0)).Help("share of outliers");
  b.Field("inlier_threshold", inlier_threshold, Positive()).Help("ε, in the picture's unit");
  b.Field("model_sampling", model_sampling)
      .Help("offset uniform among those that meet the box, or through a uniform point of it (docs/generators.md)");
  b.Field("noise", noise).Help("of the inliers' distances");
  b.Field("noise_scale", sigma, AtLeast(0.0))
      .Help("σ (gaussian) or half width (uniform), in the picture's unit; 0: ε/3 (gaussian) or ε (uniform)");
  b.Field("outliers", outliers).Help("how they lie");
  BindStream(b);
  b.Require(IsWhole(num_points), "num_points", "whole numbers");
}

std::unique_ptr<Dataset> MakeSynthetic(Task task, const SyntheticOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  CheckCounts(options.num_points, task);
  if (task == Task::kLine) return std::make_unique<SyntheticDataset<LineSection>>(options, seed);
  return std::make_unique<SyntheticDataset<PlaneSection>>(options, seed);
}

namespace {

const RegisteredDataset<SyntheticOptions> kSyntheticLine("synthetic_line", DataSource::kGenerated,
                                                         "Random lines in a 10 × 10 picture.",
                                                         [](const SyntheticOptions& options, std::uint64_t seed) {
                                                           return MakeSynthetic(Task::kLine, options, seed);
                                                         });
const RegisteredDataset<SyntheticOptions> kSyntheticPlane("synthetic_plane", DataSource::kGenerated,
                                                          "Random planes in a 10 × 10 × 10 cube.",
                                                          [](const SyntheticOptions& options, std::uint64_t seed) {
                                                            return MakeSynthetic(Task::kPlane, options, seed);
                                                          });

}  // namespace

}  // namespace diffsac
