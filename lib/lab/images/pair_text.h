#pragma once

#include <cstdint>
#include <string>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// Milliseconds of what happens before an estimate.
struct PairTimes {
  double keypoints = 0.0, matching = 0.0;
};

/// Of matches, for people: Estimate::scores_ignored.
inline constexpr const char* kScoresIgnored = ", their ratios or scores not used";

/// What an estimate says of two images, for a terminal: matrix, pose where it has one, inliers, noise, milliseconds by
/// stage. Without an estimate, why.
std::string PairText(const Example& pair, const Estimate& estimate, const PairTimes& times);

/// R in three lines, and by how many degrees it turns about which axis.
std::string RotationText(const Eigen::Matrix3d& rotation);

/// The greatest standard deviations of a 6 × 6 covariance in the order (ω, t), t of known length.
std::string PoseSpreadText(const Eigen::MatrixXd& covariance);

/// Of what the matches leave open, why, for people: "t is not determined: the camera only turned". Empty where it is
/// determined.
std::string UndeterminedText(Degeneracy translation, Task task);

/// A line each: x1 y1 x2 y2 ratio, with all digits; ratio 1 where it is unknown. Where similarities are known
/// (Problem::scale_rotation_changes) theirs follow.
std::string MatchesText(const Problem& problem);

/// What was run on two images.
struct PairRun {
  std::string image1, image2;  ///< Files.
  std::string method;          ///< The row.
  std::uint64_t seed = 0;
};

/// The same as one JSON object, with the images, method and seed, K where it is known, the matches and the rows of the
/// inliers.
std::string PairJson(const Example& pair, const Estimate& estimate, const PairTimes& times, const PairRun& run = {});

}  // namespace diffsac
