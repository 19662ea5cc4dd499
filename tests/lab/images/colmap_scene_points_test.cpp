// Photographs of a textured plane and their model, made here, to matches of images and scene points.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>

#include "core/errors.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/images/image_features.h"
#include "lab/images/image_test_util.h"
#include "lab/images/run_pairs.h"

namespace diffsac {
namespace {

constexpr int kImages = 4;

std::string Text(const char* format, double a, double b) {
  char text[80];
  std::snprintf(text, sizeof(text), format, a, b);
  return text;
}

/// A COLMAP model of kImages images, its points being keypoints of the first one; written to `root`.
void MakeModel(const std::string& root) {
  MakeFolder(root + "/images");
  MakeFolder(root + "/sparse/0");
  const ImageSize size = {320, 240};
  LensCamera camera;
  camera.K << 300, 0, 160, 0, 300, 120, 0, 0, 1;
  const cv::Mat texture = Texture(700, 600, 3);
  std::vector<RigidMotion> poses;
  for (int i = 0; i < kImages; ++i) {
    poses.push_back(NearbyPose(i));
    WriteImage(root + "/images/" + std::to_string(i) + ".png", Render(texture, camera, poses[i], size));
  }
  const ImageFeatures features = ExtractFeatures(root + "/images/0.png", {});
  std::string points, images;
  std::vector<Eigen::Vector3d> scene;
  for (Eigen::Index k = 0; k < features.positions.rows(); ++k) {
    // The first camera is the world; the plane is at z = 5.
    const Eigen::Vector3d ray = camera.K.inverse() * Eigen::Vector2d(features.positions.row(k)).homogeneous();
    scene.push_back(5.0 * ray);
    points += std::to_string(k) + Text(" %.9g %.9g 5 0 0 0 0.1 1 0\n", scene.back()[0], scene.back()[1]);
  }
  for (int i = 0; i < kImages; ++i) {
    const Eigen::Quaterniond q(poses[i].rotation);
    const Eigen::Vector3d& t = poses[i].translation;
    images += std::to_string(i) + Text(" %.12g %.12g", q.w(), q.x()) + Text(" %.12g %.12g", q.y(), q.z()) +
              Text(" %.12g %.12g", t[0], t[1]) + Text(" %.12g 1 %.0f.png\n", t[2], i);
    for (std::size_t k = 0; k < scene.size(); ++k) {
      const Eigen::Vector2d pixel = (camera.K * (poses[i].rotation * scene[k] + t)).hnormalized();
      images += Text("%.6f %.6f ", pixel[0] + 0.5, pixel[1] + 0.5) +
                std::to_string(k % 7 == 0 ? -1 : static_cast<int>(k)) + " ";
    }
    images += "\n";
  }
  WriteRaw(root + "/sparse/0/cameras.txt", "1 PINHOLE 320 240 300 300 160.5 120.5\n");
  WriteRaw(root + "/sparse/0/images.txt", images);
  WriteRaw(root + "/sparse/0/points3D.txt", points);
}

PairsRequest Request(const std::string& input, const std::string& output) {
  PairsRequest request;
  request.format = "colmap_points";
  request.input = input;
  request.output = output;
  request.options.threads = 1;
  return request;
}

}  // namespace

TEST_CASE("images against the points that the others see: most matches are right, and stay as they are") {
  TemporaryFolder folder;
  const std::string root = folder / "wall", output = folder / "poses";
  MakeModel(root);
  const std::atomic<bool> go{false}, stop{true};
  CHECK_FALSE(RunPairs(Request(root, output), stop).finished);
  CHECK_FALSE(std::filesystem::exists(output + "/wall/scene_points.h5"));
  const PrepareResult result = RunPairs(Request(root, output), go);
  CHECK(result.finished);
  CHECK(result.written == 1);
  CHECK(RunPairs(Request(root, output), go).already_there == 1);
  const auto dataset = MakeDataset(
      ConfigFromYaml("{type: absolute_poses, paths: [" + output + "], inlier_threshold_px: 2}", "a.yaml"), 1);
  REQUIRE(dataset->size() == kImages);
  for (int i = 0; i < kImages; ++i) {
    const Example example = dataset->Get(i);
    CHECK(example.id == "wall/" + std::to_string(i));
    CHECK((RotationOf(example.truth.model) - NearbyPose(i).rotation).norm() < 1e-9);
    int inliers = 0;
    for (const auto inlier : example.truth.inliers) inliers += inlier;
    CAPTURE(i, inliers, example.problem.points.rows());
    CHECK(inliers > 50);
    CHECK(inliers > 0.7 * static_cast<double>(example.problem.points.rows()));
  }
}

TEST_CASE("models without sound points name what is wrong") {
  TemporaryFolder folder;
  const std::string root = folder / "wall", output = folder / "poses";
  MakeModel(root);
  const std::atomic<bool> go{false};
  const auto error = [&](const PairsRequest& request) { return ErrorOf([&] { RunPairs(request, go); }); };
  PairsRequest orb = Request(root, output);
  orb.options.features.kind = FeatureKind::kOrb;
  CHECK(Has(error(orb), "sift or rootsift"));
  WriteRaw(root + "/sparse/0/points3D.txt", "1 2 3\n");
  CHECK(Has(error(Request(root, output)), "points3D.txt:1: expected POINT3D_ID"));
  WriteRaw(root + "/sparse/0/points3D.txt", "# nothing\n");
  CHECK(Has(error(Request(root, output)), "there is no point"));
  std::filesystem::remove(root + "/sparse/0/points3D.txt");
  CHECK(Has(error(Request(root, output)), "points3D.txt"));
  WriteRaw(root + "/images/2.png", "broken");
  WriteRaw(root + "/sparse/0/points3D.txt", "1 0 0 5 0 0 0 0.1 1 0\n");
  CHECK(Has(error(Request(root, output)), "no point of another image"));
  CHECK_FALSE(std::filesystem::exists(output + "/wall/scene_points.h5"));
}

}  // namespace diffsac
