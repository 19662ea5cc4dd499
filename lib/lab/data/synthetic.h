#pragma once

#include <memory>
#include <string>

#include "diffsac/problem/tasks.h"
#include "lab/data/box_section.h"
#include "lab/data/generator.h"
#include "lab/data/instance_sizes.h"
#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// Of the inliers' distances; uniform is within ±sigma.
enum class NoiseKind { kGaussian, kUniform };
template <>
inline constexpr auto kEnumNames<NoiseKind> = NamesOf<NoiseKind>({{NoiseKind::kGaussian, "gaussian"},
                                                                  {NoiseKind::kUniform, "uniform"}});

/// How outliers lie: anywhere, or in clusters.
enum class OutlierKind { kUniform, kAggregated };
template <>
inline constexpr auto kEnumNames<OutlierKind> = NamesOf<OutlierKind>({{OutlierKind::kUniform, "uniform"},
                                                                      {OutlierKind::kAggregated, "aggregated"}});

/// Random lines in a 10 × 10 picture, or planes in a 10 × 10 × 10 cube (paper, sections "2D Line Fitting" and "3D Plane
/// Fitting"). What the paper leaves open is fixed in docs/generators.md.
struct SyntheticOptions : GeneratorOptions {
  Range num_points = {100, 100};
  Range outlier_ratio = {0.1, 0.8};
  double inlier_threshold = 0.1;
  ModelSampling model_sampling = ModelSampling::kIsotropic;
  NoiseKind noise = NoiseKind::kGaussian;
  double sigma = 0.0;
  OutlierKind outliers = OutlierKind::kUniform;
  // No keys:
  int clusters = 3;            ///< aggregated: number of clusters
  double cluster_sigma = 0.5;  ///< aggregated: standard deviation of a cluster
  double min_extent = 5.0;     ///< shortest chord (lines); planes: smallest square root of the area inside
  void Bind(OptionsBinder& b);
};

/// Deterministic in (options, seed, index). Points are shuffled. Inliers: floor/round of N·(1−ratio), at least γ + 1.
std::unique_ptr<Dataset> MakeSynthetic(Task task, const SyntheticOptions& options, std::uint64_t seed);

/// Several random lines in a 10 × 10 picture, or planes in a 10 × 10 × 10 cube, and uniform outliers. They may cross.
/// Two of them are told apart: less than half of either lies within 2 ε of the other. What is drawn, and how, is in
/// docs/generators.md.
struct SyntheticInstancesOptions : GeneratorOptions {
  Task task = Task::kLine;
  InstanceOptions instances;
  Range num_points = {100, 100};
  Range outlier_ratio = {0.3, 0.3};
  double inlier_threshold = 0.1;
  double sigma = 0.0;
  // No keys:
  ModelSampling model_sampling = ModelSampling::kIsotropic;
  double min_extent = 5.0;  ///< shortest chord (lines); planes: smallest square root of the area inside
  void Bind(OptionsBinder& b);
};

/// Deterministic in (options, seed, index). Truth: structures and labels, largest first, inliers of any of them, model
/// of the largest. A point belongs to the structure that made it, also where they cross. Points are shuffled.
std::unique_ptr<Dataset> MakeSyntheticInstances(const SyntheticInstancesOptions& options, std::uint64_t seed);

}  // namespace diffsac
