#pragma once

#include <Eigen/Core>
#include <vector>

#include "diffsac/core/random.h"
#include "lab/data/generator.h"
#include "lab/data/virtual_views.h"
#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// How exact correspondences of two virtual views become a problem (docs/generators.md): noise, outliers, ratios.
/// Everything is drawn for each problem anew.
struct SyntheticMatchesOptions {
  Range num_points = {100, 500};
  Range outlier_ratio = {0.1, 0.8};
  double inlier_threshold_px = 1.0;
  Range noise_px = {0.2, 0.8};
  Range displaced_share = {0.0, 0.4};
  Range displacement_px = {5.0, 200.0};
  bool snn_ratio = true;
  Range correct_ratio_power = {0.7, 1.8};
  Range wrong_ratio_power = {7.0, 12.0};
  bool scale_rotation_changes = false;
  Range similarity_noise = {0.06, 0.14};
  Range gross_scale_rotation_changes = {0.0, 0.03};
  Range wrong_scale_spread = {0.5, 1.1};
  void Bind(OptionsBinder& b);
  PointCounts DrawCounts(Task task, const Rng& rng) const {
    return diffsac::DrawCounts(num_points, outlier_ratio, task, rng);
  }
};

/// Exact correspondences, x1 y1 x2 y2 in pixels.
struct ExactMatches {
  std::vector<Eigen::Vector4d> inliers;    ///< of the model
  std::vector<Eigen::Vector4d> others;     ///< correct matches that the model does not explain; they count as outliers
  std::vector<Eigen::Vector4d> displaced;  ///< correct matches to be displaced
  std::vector<Eigen::Matrix3d> planes = {};  ///< x2 ~ H x1: those that matches may lie on, as far as they are known
};

/// How many outliers of a problem are displaced matches.
int DrawDisplacedCount(const SyntheticMatchesOptions& options, int outliers, Rng rng);

/// The problem and its truth but for models, pose and names: noise on inliers, others and displaced, then uniform
/// outliers up to `total`, ratios, and all shuffled. Cameras and sizes come from `pair`.
/// Outliers are not filtered: one that the model explains by accident is still an outlier.
Example MakeMatches(const SyntheticMatchesOptions& options, Task task, const VirtualPair& pair,
                    const ExactMatches& exact, int total, const Rng& rng);

/// Model (E, F from the motion; H as given), relative pose with a unit translation (zero stays zero).
void SetTruth(const VirtualPair& pair, const Eigen::Matrix3d& homography, Example* example);

/// A row of Problem::scale_rotation_changes: the similarity nearest to how the surroundings of an exact correspondence
/// go from image 1 to image 2. On the first of `planes` (x2 ~ H x1, pixels) that it obeys it is that of the plane, else
/// that of a small patch which faces both cameras alike, or of infinity where its depth cannot be told: the cameras
/// have one centre, or it lies at an epipole.
Eigen::RowVector2d LocalSimilarity(const VirtualPair& pair, const std::vector<Eigen::Matrix3d>& planes,
                                   const Eigen::Vector4d& match);

}  // namespace diffsac
