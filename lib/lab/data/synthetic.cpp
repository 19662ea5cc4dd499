#include "lab/data/synthetic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_registry.h"

namespace diffsac {
namespace {

// Side of the square and of the cube in which synthetic lines and planes lie.
constexpr double kBoxSide = 10.0;

// LineSection::Point or PlaneSection::Point.
template <class Section>
using PointOf = typename Section::Point;

// A section of at least `min_extent`. Any value up to kBoxSide can be met.
template <class Section>
Section DrawSection(ModelSampling sampling, double min_extent, Rng& rng) {
  for (;;) {
    Section section = Section::Random(kBoxSide, rng, sampling);
    if (section.extent() > 0.0 && section.extent() >= min_extent) return section;
  }
}

// Displacements along the normal: of standard deviation (gaussian) or half width (uniform) `scale`; 0 means ε/3 or ε.
class NoiseSource {
 public:
  NoiseSource(NoiseKind kind, double scale, double inlier_threshold, Rng rng)
      : gaussian_(kind == NoiseKind::kGaussian), rng_(rng) {
    const double standard = gaussian_ ? inlier_threshold / 3.0 : inlier_threshold;
    scale_ = scale > 0.0 ? scale : standard;
  }
  double Next() { return gaussian_ ? scale_ * rng_.Normal() : rng_.Uniform(-scale_, scale_); }

 private:
  bool gaussian_;
  double scale_ = 0.0;
  Rng rng_;
};

// Uniform on the section, displaced along its normal.
template <class Section>
void AppendOnSection(const Section& section, int count, NoiseSource noise, Rng rng,
                     std::vector<PointOf<Section>>* points) {
  for (int i = 0; i < count; ++i) {
    PointOf<Section> p = section.Sample(rng);
    const double displacement = noise.Next();
    for (int k = 0; k < Section::kDimension; ++k) p[k] += displacement * section.normal()[k];
    points->push_back(p);
  }
}

// Uniform in the box.
template <class Point>
void AppendUniform(int count, Rng rng, std::vector<Point>* points) {
  for (int i = 0; i < count; ++i) {
    Point p;
    for (double& value : p) value = rng.Uniform(0.0, kBoxSide);
    points->push_back(p);
  }
}

// The points and their labels in a random order.
template <class Point>
void SetShuffled(const std::vector<Point>& points, const std::vector<std::int32_t>& labels, Rng rng, Example* example) {
  const auto count = static_cast<int>(points.size());
  example->problem.points.resize(count, static_cast<Eigen::Index>(Point().size()));
  for (const int from : rng.Permutation(count)) {
    const auto row = static_cast<Eigen::Index>(example->truth.assignment.size());
    for (std::size_t k = 0; k < Point().size(); ++k) example->problem.points(row, k) = points[from][k];
    example->truth.assignment.push_back(labels[from]);
  }
}

// (n, d).
template <class Section>
ModelParameters ParametersOf(const Section& section) {
  ModelParameters model(Section::kDimension + 1);
  for (int k = 0; k < Section::kDimension; ++k) model[k] = section.normal()[k];
  model[Section::kDimension] = section.offset();
  return model;
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

// Two structures are told apart when less than this share of either lies within so many ε of the other, measured on so
// many points of it.
constexpr double kSharedMost = 0.5;
constexpr double kSharedThresholds = 2.0;
constexpr int kSharedSamples = 64;
// Up to this ε the band around a structure is narrow enough for twenty others beside it.
constexpr double kLargestThreshold = 0.05 * kBoxSide;

template <class Section>
double DistanceOf(const PointOf<Section>& point, const Section& section) {
  double sum = section.offset();
  for (int k = 0; k < Section::kDimension; ++k) sum += point[k] * section.normal()[k];
  return std::abs(sum);
}

template <class Section>
double ShareWithin(const Section& of, const Section& other, double distance, Rng rng) {
  int near = 0;
  for (int i = 0; i < kSharedSamples; ++i) near += DistanceOf(of.Sample(rng), other) <= distance;
  return static_cast<double>(near) / kSharedSamples;
}

// One dataset for both tasks; Section is LineSection or PlaneSection.
template <class Section>
class SyntheticInstances : public GeneratedDataset {
 public:
  static constexpr int kDimension = Section::kDimension;

  SyntheticInstances(const SyntheticInstancesOptions& options, std::uint64_t seed)
      : GeneratedDataset(options, "synthetic_structures_" + ToString(options.task) + "/" + options.split,
                         "structures_" + ToString(options.task) + "/" + options.split + "/", seed),
        options_(options) {}

  Task task() const override { return options_.task; }

 private:
  Example Draw(std::uint64_t /*index*/, const Rng& rng) const override {
    const std::vector<int> sizes = DrawSizes(rng);
    const std::vector<Section> sections = DrawSections(static_cast<int>(sizes.size()), rng);
    std::vector<PointOf<Section>> points;
    std::vector<std::int32_t> labels;
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      const NoiseSource noise(NoiseKind::kGaussian, options_.sigma, options_.inlier_threshold, rng.Fork("noise", k));
      AppendOnSection(sections[k], sizes[k], noise, rng.Fork("inliers", k), &points);
      labels.resize(points.size(), static_cast<std::int32_t>(k + 1));
    }
    const int total = DrawTotal(rng);
    AppendUniform(total - static_cast<int>(points.size()), rng.Fork("outliers"), &points);
    labels.resize(points.size(), 0);

    Example example;
    example.problem.task = options_.task;
    example.problem.inlier_threshold = options_.inlier_threshold;
    SetShuffled(points, labels, rng.Fork("shuffle"), &example);
    for (const Section& section : sections) example.truth.instances.push_back(ParametersOf(section));
    ArrangeInstances(1, &example.truth);
    return example;
  }

  int DrawTotal(const Rng& rng) const {
    Rng totals = rng.Fork("total");
    return DrawWhole(options_.num_points, totals);
  }

  // The numbers of points of the structures, largest first.
  std::vector<int> DrawSizes(const Rng& rng) const {
    const int total = DrawTotal(rng), fewest = FewestOfInstance(options_.task);
    Rng counts = rng.Fork("structures"), ratios = rng.Fork("outlier_ratio");
    const int count = DrawWhole(options_.instances.instances, counts);
    const double ratio = ratios.Uniform(options_.outlier_ratio.low, options_.outlier_ratio.high);
    const int wanted = static_cast<int>(std::lround(total * (1.0 - ratio)));
    return DrawInstanceSizes(options_.instances, count, std::clamp(wanted, count * fewest, total), fewest,
                             rng.Fork("sizes"));
  }

  // A stream for each: with more structures the first ones stay as they are.
  std::vector<Section> DrawSections(int count, const Rng& rng) const {
    std::vector<Section> sections;
    for (int k = 0; k < count; ++k) {
      Rng models = rng.Fork("model", k);
      Section section = DrawSection<Section>(options_.model_sampling, options_.min_extent, models);
      while (!IsToldApart(section, sections, models.Fork("shared")))
        section = DrawSection<Section>(options_.model_sampling, options_.min_extent, models);
      sections.push_back(section);
    }
    return sections;
  }

  bool IsToldApart(const Section& section, const std::vector<Section>& others, const Rng& rng) const {
    const double distance = kSharedThresholds * options_.inlier_threshold;
    return std::none_of(others.begin(), others.end(), [&](const Section& other) {
      return ShareWithin(section, other, distance, rng) >= kSharedMost ||
             ShareWithin(other, section, distance, rng) >= kSharedMost;
    });
  }

  SyntheticInstancesOptions options_;
};

void SyntheticInstancesOptions::Bind(OptionsBinder& b) {
  b.Field("task", task, {Task::kLine, Task::kPlane}).Help("what is estimated");
  instances.Bind(b);
  b.Field("num_points", num_points, Within(3, 1e7)).Help("points of a problem");
  b.Field("outlier_ratio", outlier_ratio, Within(0.0, 1.0)).Help("share of points on no structure");
  b.Field("inlier_threshold", inlier_threshold, Limits{0.0, kLargestThreshold, true}).Help("ε, in the picture's unit");
  b.Field("noise_scale", sigma, AtLeast(0.0))
      .Help("σ of the inliers' distances (gaussian), in the picture's unit; 0: ε/3");
  BindStream(b);
  b.Require(IsWhole(num_points), "num_points", "whole numbers");
}

std::unique_ptr<Dataset> MakeSyntheticInstances(const SyntheticInstancesOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  CheckInstances(options.instances, options.task, options.num_points.low);
  if (options.task == Task::kLine) return std::make_unique<SyntheticInstances<LineSection>>(options, seed);
  return std::make_unique<SyntheticInstances<PlaneSection>>(options, seed);
}

const RegisteredDataset<SyntheticInstancesOptions> kSyntheticInstances(
    "synthetic_structures", DataSource::kGenerated,
    "Several random lines in a 10 × 10 picture, or planes in a 10 × 10 × 10 cube.", MakeSyntheticInstances);

}  // namespace diffsac
