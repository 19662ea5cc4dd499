#include "lab/data/synthetic_matches.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "diffsac/core/status.h"
#include "diffsac/problem/keypoint_similarity.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/instance_sizes.h"

namespace diffsac {
namespace {

// A displacement is drawn again while it leads out of the image; a point that is hemmed in becomes a uniform outlier.
constexpr int kDisplacementTries = 20;

enum class Origin : std::uint8_t { kInlier, kOther, kWrong };

struct Match {
  Eigen::Vector4d pixels;
  Origin origin;
};

Eigen::Vector4d UniformMatch(const VirtualPair& pair, Rng& rng) {
  Eigen::Vector4d match;
  match.head<2>() = pair.first.RandomPixel(rng);
  match.tail<2>() = pair.second.RandomPixel(rng);
  return match;
}

Eigen::Vector4d Displaced(const Eigen::Vector4d& exact, const SyntheticMatchesOptions& options, const VirtualPair& pair,
                          Rng& rng) {
  for (int i = 0; i < kDisplacementTries; ++i) {
    const double length = LogUniform(options.displacement_px, rng), angle = rng.Uniform(0.0, 2.0 * std::numbers::pi);
    const Eigen::Vector2d place = exact.tail<2>() + length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    if (!pair.second.Contains(place)) continue;
    Eigen::Vector4d match = exact;
    match.tail<2>() = place;
    return match;
  }
  return UniformMatch(pair, rng);
}

void AddNoise(double sigma, Rng rng, std::vector<Match>* matches) {
  for (Match& match : *matches)
    for (double& value : match.pixels) value += sigma * rng.Normal();
}

// The smallest ratio that is written: real ones are never 0.
double DrawRatio(double power, Rng& rng) { return std::max(1e-6, std::pow(rng.Uniform(), 1.0 / power)); }

Eigen::VectorXd DrawRatios(const SyntheticMatchesOptions& options, const std::vector<Match>& matches, Rng rng) {
  if (!options.snn_ratio) return {};
  Rng powers = rng.Fork("powers");
  const double correct = LogUniform(options.correct_ratio_power, powers);
  const double wrong = LogUniform(options.wrong_ratio_power, powers);
  Eigen::VectorXd ratios(static_cast<Eigen::Index>(matches.size()));
  for (std::size_t i = 0; i < matches.size(); ++i)
    ratios[static_cast<Eigen::Index>(i)] = DrawRatio(matches[i].origin == Origin::kWrong ? wrong : correct, rng);
  return ratios;
}

// Of `total` matches, of which those before the uniform ones are given as noise has not moved them yet.
PointMatrix DrawScaleRotationChanges(const SyntheticMatchesOptions& options, const VirtualPair& pair,
                                     const std::vector<Eigen::Matrix3d>& planes, const std::vector<Match>& exact,
                                     int total, Rng rng) {
  if (!options.scale_rotation_changes) return {};
  const auto uniform = [&rng](const Range& range) { return rng.Uniform(range.low, range.high); };
  const double noise = uniform(options.similarity_noise), gross = uniform(options.gross_scale_rotation_changes);
  const double spread = uniform(options.wrong_scale_spread);
  const std::size_t count = std::max(exact.size(), static_cast<std::size_t>(total));
  PointMatrix scale_rotation_changes(static_cast<Eigen::Index>(count), 2);
  for (std::size_t i = 0; i < count; ++i) {
    const bool wrong = i >= exact.size() || exact[i].origin == Origin::kWrong || rng.Uniform() < gross;
    const Eigen::RowVector2d any(spread * rng.Normal(), rng.Uniform(-std::numbers::pi, std::numbers::pi));
    const Eigen::RowVector2d error(noise * rng.Normal(), noise * rng.Normal());
    scale_rotation_changes.row(static_cast<Eigen::Index>(i)) =
        wrong ? any : SimilarityOf(-error, LocalSimilarity(pair, planes, exact[i].pixels));
  }
  return scale_rotation_changes;
}

}  // namespace

void SyntheticMatchesOptions::Bind(OptionsBinder& b) {
  b.Field("num_points", num_points, Within(5, 1e6)).Help("matches of a problem");
  b.Field("outlier_ratio", outlier_ratio, Within(0.0, 1.0)).Help("share of outliers");
  b.Field("inlier_threshold_px", inlier_threshold_px, Positive()).Help("ε, linear, pixels");
  b.Field("noise_px", noise_px, AtLeast(0.0)).Help("σ of each coordinate in both images; one value a problem");
  b.Field("match_ratio", snn_ratio).Help("whether matches have a ratio, P(ratio <= r) = r^a");
  b.Field("similarities", scale_rotation_changes)
      .Help("whether matches know how their keypoints differ in size and angle");
  b.Require(IsWhole(num_points), "num_points", "whole numbers");
}

int DrawDisplacedCount(const SyntheticMatchesOptions& options, int outliers, Rng rng) {
  return static_cast<int>(
      std::lround(rng.Uniform(options.displaced_share.low, options.displaced_share.high) * outliers));
}

Example MakeMatches(const SyntheticMatchesOptions& options, Task task, const VirtualPair& pair,
                    const ExactMatches& exact, int total, const Rng& rng) {
  std::vector<Match> matches;
  matches.reserve(total);
  Rng displacement = rng.Fork("displacement");
  for (const auto& match : exact.inliers) matches.push_back({match, Origin::kInlier});
  for (const auto& match : exact.others) matches.push_back({match, Origin::kOther});
  for (const auto& match : exact.displaced)
    matches.push_back({Displaced(match, options, pair, displacement), Origin::kWrong});
  const PointMatrix scale_rotation_changes =
      DrawScaleRotationChanges(options, pair, exact.planes, matches, total, rng.Fork("similarities"));
  Rng noise = rng.Fork("noise");
  const double sigma = noise.Uniform(options.noise_px.low, options.noise_px.high);
  AddNoise(sigma, noise, &matches);
  Rng uniform = rng.Fork("uniform");
  while (static_cast<int>(matches.size()) < total) matches.push_back({UniformMatch(pair, uniform), Origin::kWrong});
  const Eigen::VectorXd ratios = DrawRatios(options, matches, rng.Fork("ratios"));

  Example example;
  Problem& problem = example.problem;
  problem.task = task;
  SetThreshold(options.inlier_threshold_px, &problem);
  problem.cameras = CameraPair{pair.first.K, pair.second.K};
  problem.size1 = pair.first.size;
  problem.size2 = pair.second.size;
  const auto count = static_cast<int>(matches.size());
  const std::vector<int> order = rng.Fork("shuffle").Permutation(count);
  problem.points.resize(count, 4);
  problem.snn_ratio.resize(ratios.size());
  if (scale_rotation_changes.rows() > 0) problem.scale_rotation_changes = scale_rotation_changes(order, Eigen::all);
  example.truth.inliers.resize(count);
  for (int i = 0; i < count; ++i) {
    problem.points.row(i) = matches[order[i]].pixels.transpose();
    if (ratios.size() > 0) problem.snn_ratio[i] = ratios[order[i]];
    example.truth.inliers[i] = matches[order[i]].origin == Origin::kInlier;
  }
  return example;
}

void SetTruth(const VirtualPair& pair, const Eigen::Matrix3d& homography, Example* example) {
  const RigidMotion& motion = pair.motion;
  example->truth.pose = PoseOf(motion);
  HideCalibration(example);
  GroundTruth known = example->truth;
  known.homography = homography;
  known.essential = EssentialFromMotion(motion);
  known.fundamental = FundamentalFromEssential(*known.essential, pair.first.K, pair.second.K);
  example->truth.model = TrueModel(example->problem, known);
}

namespace {

// How far, in pixels, an exact match may be from its plane's homography by rounding.
constexpr double kOnPlanePx = 1e-6;

Eigen::Vector2d Mapped(const Eigen::Matrix3d& H, const Eigen::Vector2d& pixel) {
  return (H * pixel.homogeneous()).hnormalized();
}

// Of the patch at a match.
Eigen::Matrix3d PatchHomography(const VirtualPair& pair, const Eigen::Vector4d& match) {
  const RigidMotion& motion = pair.motion;
  const Eigen::Vector3d ray1 = pair.first.Ray(match.head<2>()), ray2 = pair.second.Ray(match.tail<2>());
  Eigen::Matrix3d between = motion.rotation;
  // Depths z1, z2 with z2 ray2 = z1 R ray1 + t. There are none at an epipole, and without a baseline.
  Eigen::Matrix<double, 3, 2> rays;
  rays << -motion.rotation * ray1, ray2;
  const Eigen::Vector2d depths = rays.colPivHouseholderQr().solve(motion.translation);
  if (depths.minCoeff() > 0.0) {
    const Eigen::Vector3d normal = (ray1.normalized() + motion.rotation.transpose() * ray2.normalized()).normalized();
    between += motion.translation * normal.transpose() / (depths[0] * normal.dot(ray1));
  }
  return pair.second.K * between * pair.first.K.inverse();
}

Eigen::Matrix3d HomographyAt(const VirtualPair& pair, const std::vector<Eigen::Matrix3d>& planes,
                             const Eigen::Vector4d& match) {
  for (const Eigen::Matrix3d& H : planes)
    if ((Mapped(H, match.head<2>()) - match.tail<2>()).norm() < kOnPlanePx) return H;
  return PatchHomography(pair, match);
}

}  // namespace

Eigen::RowVector2d LocalSimilarity(const VirtualPair& pair, const std::vector<Eigen::Matrix3d>& planes,
                                   const Eigen::Vector4d& match) {
  const Eigen::Matrix3d H = HomographyAt(pair, planes, match);
  const Eigen::Vector3d image = H * match.head<2>().homogeneous();
  // The derivative of the mapping.
  const Eigen::Matrix2d A = (H.topLeftCorner<2, 2>() - image.hnormalized() * H.bottomLeftCorner<1, 2>()) / image[2];
  const Eigen::Vector2d similar(A(0, 0) + A(1, 1), A(1, 0) - A(0, 1));
  return {std::log(0.5 * similar.norm()), std::atan2(similar[1], similar[0])};
}

}  // namespace diffsac
