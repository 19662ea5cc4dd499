// Generated scenes with one image each, for absolute poses: docs/generators.md.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/generator.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

constexpr int kWidth = 1200, kHeight = 900;

struct SyntheticAbsolutePoseOptions : GeneratorOptions {
  Range num_points = {200, 200};
  Range outlier_ratio = {0.1, 0.8};
  double inlier_threshold_px = 3.0;
  double noise_px = 1.0;
  Range depth = {4.0, 12.0};
  double flatness = 0.0;

  void Bind(OptionsBinder& b) {
    b.Field("num_points", num_points, Within(4, 1e6)).Help("points of a scene");
    b.Field("outlier_ratio", outlier_ratio, Within(0.0, 1.0)).Help("share of points whose image is anywhere");
    b.Field("inlier_threshold_px", inlier_threshold_px, Positive()).Help("ε, of the reprojection error");
    b.Field("noise_px", noise_px, AtLeast(0.0)).Help("σ of each coordinate of an image");
    b.Field("depth", depth, Positive()).Help("of the scene's points before the camera, in the scene's unit");
    b.Field("flatness", flatness, Within(0.0, 1.0)).Help("1: all points on one plane");
    BindStream(b);
  }
};

class SyntheticAbsolutePose : public GeneratedDataset {
 public:
  SyntheticAbsolutePose(const SyntheticAbsolutePoseOptions& options, std::uint64_t seed)
      : GeneratedDataset(options, "synthetic_absolute_pose/" + options.split, "", seed), options_(options) {}

  Task task() const override { return Task::kAbsolutePose; }

 private:
  Example Draw(std::uint64_t /*index*/, const Rng& stream) const override {
    Rng rng = stream;
    Example example;
    Problem& problem = example.problem;
    problem.task = task();
    problem.inlier_threshold = options_.inlier_threshold_px;
    const double focal = kWidth * rng.Uniform(0.8, 1.5);
    problem.cameras.emplace();
    problem.cameras->K1 << focal, 0.0, 0.5 * kWidth, 0.0, focal, 0.5 * kHeight, 0.0, 0.0, 1.0;
    problem.cameras->K2 = problem.cameras->K1;
    problem.size1 = {kWidth, kHeight};
    const Eigen::Matrix3d rotation =
        Eigen::Quaterniond(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal()).normalized().toRotationMatrix();
    const Eigen::Vector3d translation(rng.Normal(), rng.Normal(), rng.Normal());
    example.truth.model = PoseOf(rotation, translation);
    AddPoints(rng, &example);
    return example;
  }

  static double Draw(const Range& range, Rng& rng) { return rng.Uniform(range.low, range.high); }

  // In random order: outliers, whose images are anywhere, and inliers. The scene is made of what the image shows, so
  // that all of it is before the camera.
  void AddPoints(Rng& rng, Example* example) const {
    const int count = static_cast<int>(std::lround(Draw(options_.num_points, rng)));
    const int outliers = std::min(static_cast<int>(std::lround(Draw(options_.outlier_ratio, rng) * count)), count - 4);
    const Eigen::Matrix3d rotation = RotationOf(example->truth.model);
    const Eigen::Vector3d translation = TranslationOf(example->truth.model);
    const Eigen::Matrix3d inverse = example->problem.cameras->K1.inverse();
    // A plane through the middle of what is seen, which a flat scene is on.
    const Eigen::Vector3d normal = Eigen::Vector3d(0.6 * rng.Normal(), 0.6 * rng.Normal(), 1.0).normalized();
    const double middle = Draw(options_.depth, rng);
    const std::vector<int> order = rng.Permutation(count);
    example->problem.points.resize(count, 5);
    example->truth.inliers.assign(count, 0);
    const auto anywhere = [&] { return Eigen::Vector2d(rng.Uniform(0.0, kWidth), rng.Uniform(0.0, kHeight)); };
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d pixel = anywhere();
      const Eigen::Vector3d ray = inverse * pixel.homogeneous();
      const double on_plane = std::max(0.1 * middle, middle * normal[2] / std::max(normal.dot(ray), 0.1));
      const double depth = options_.flatness * on_plane + (1.0 - options_.flatness) * Draw(options_.depth, rng);
      Eigen::Vector2d seen = pixel + options_.noise_px * Eigen::Vector2d(rng.Normal(), rng.Normal());
      if (i < outliers) seen = anywhere();
      example->problem.points.row(order[i]) << (rotation.transpose() * (depth * ray - translation)).transpose(),
          seen.transpose();
      example->truth.inliers[order[i]] = (seen - pixel).norm() <= options_.inlier_threshold_px ? 1 : 0;
    }
  }

  SyntheticAbsolutePoseOptions options_;
};

const RegisteredDataset<SyntheticAbsolutePoseOptions> kSyntheticAbsolutePose(
    "synthetic_absolute_pose", DataSource::kGenerated, "One image of a random scene, for absolute poses.",
    [](const SyntheticAbsolutePoseOptions& options, std::uint64_t seed) {
      return std::make_unique<SyntheticAbsolutePose>(options, seed);
    });

}  // namespace
}  // namespace diffsac
