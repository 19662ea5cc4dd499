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

// The second model of structured outliers has at most this share of the inliers' number: it stays the weaker one.
constexpr double kWeakerShare = 0.75;

template <class Section>
Section DrawSection(const SyntheticOptions& options, Rng rng) {
  return DrawSection<Section>(options.model_sampling, options.min_extent, rng);
}

NoiseSource NoiseOf(const SyntheticOptions& options, Rng rng) {
  return {options.noise, options.sigma, options.inlier_threshold, rng};
}

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

template <class Section>
void AppendStructured(const SyntheticOptions& options, int count, int inliers, Rng rng,
                      std::vector<PointOf<Section>>* points) {
  const int wanted = static_cast<int>(std::lround(options.structured_share * count));
  const int on_second = std::min(wanted, static_cast<int>(kWeakerShare * inliers));
  const Section second = DrawSection<Section>(options, rng.Fork("second_model"));
  AppendOnSection(second, on_second, NoiseOf(options, rng.Fork("second_noise")), rng.Fork("second"), points);
  AppendUniform(count - on_second, rng.Fork("uniform"), points);
}

template <class Section>
void AppendOutliers(const SyntheticOptions& options, int count, int inliers, Rng rng,
                    std::vector<PointOf<Section>>* points) {
  if (options.outliers == OutlierKind::kAggregated) {
    AppendAggregated(options, count, rng, points);
  } else if (options.outliers == OutlierKind::kStructured) {
    AppendStructured<Section>(options, count, inliers, rng, points);
  } else {
    AppendUniform(count, rng, points);
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
    const Section section = DrawSection<Section>(options_, rng.Fork("model"));
    std::vector<PointOf<Section>> points;
    points.reserve(total);
    AppendOnSection(section, inliers, NoiseOf(options_, rng.Fork("noise")), rng.Fork("inliers"), &points);
    AppendOutliers<Section>(options_, total - inliers, inliers, rng.Fork("outliers"), &points);
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
  const bool aggregated = outliers == OutlierKind::kAggregated;
  b.Field("clusters", clusters, Within(1, 1e4)).OnlyIf(aggregated, "outliers: aggregated").Help("number of clusters");
  b.Field("cluster_sigma", cluster_sigma, Limits{0.0, kBoxSide, true})
      .OnlyIf(aggregated, "outliers: aggregated")
      .Help("standard deviation of a cluster");
  b.Field("structured_share", structured_share, Within(0.0, 1.0))
      .OnlyIf(outliers == OutlierKind::kStructured, "outliers: structured")
      .Help("share of outliers on the second, weaker model");
  // Every line and plane through the middle of the box is at least 10 large, so up to there the rule can be met.
  b.Field("min_extent", min_extent, Within(0.0, kBoxSide))
      .Help("shortest chord (lines); planes: smallest square root of the area inside");
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
