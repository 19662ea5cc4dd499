#include "lab/data/synthetic_instances.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "diffsac/core/random.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/synthetic_points.h"

namespace diffsac {
namespace {

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
    const int count = DrawInstanceCount(options_.instances, rng.Fork("structures"));
    Rng ratios = rng.Fork("outlier_ratio");
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

}  // namespace

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

namespace {

const RegisteredDataset<SyntheticInstancesOptions> kSyntheticInstances(
    "synthetic_structures", DataSource::kGenerated,
    "Several random lines in a 10 × 10 picture, or planes in a 10 × 10 × 10 cube.", MakeSyntheticInstances);

}  // namespace

}  // namespace diffsac
