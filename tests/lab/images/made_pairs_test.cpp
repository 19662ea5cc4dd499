#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/errors.h"
#include "diffsac/core/status.h"
#include "lab/files/correspondence_files.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/images/image_source.h"
#include "lab/images/modelnet_pairs.h"
#include "lab/images/warp_images.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

const std::atomic<bool> kNeverStop{false};

}  // namespace

TEST_CASE("warp: views are homographies that keep the image's centre in sight") {
  Eigen::Matrix3d first = RandomView(640, 480, 0, 65, Rng(1));
  CHECK(first == RandomView(640, 480, 0, 65, Rng(1)));
  for (int i = 0; i < 200; ++i) {
    const Eigen::Matrix3d view = RandomView(640, 480, 0, 65, Rng(2).Fork("view", i));
    const Eigen::Vector3d centre = view * Eigen::Vector3d(320, 240, 1);
    CHECK(view.allFinite());
    CHECK(view.determinant() / std::pow(view.norm(), 3) != 0.0);
    CHECK(centre.z() > 0.0);
    CHECK((centre.hnormalized() - Eigen::Vector2d(320, 240)).norm() < 0.25 * 640);
  }
}

TEST_CASE("warp: the written images and matrices are what the reader of homographies takes") {
  TemporaryFolder folder;
  fs::create_directories(folder / "in");
  cv::Mat image(120, 160, CV_8U, cv::Scalar(40));
  cv::rectangle(image, {70, 50}, {90, 70}, cv::Scalar(230), cv::FILLED);
  cv::imwrite(folder / "in/square.png", image);
  WriteRaw(folder / "in/broken.png", "no image");
  WarpRequest request;
  request.input = folder / "in";
  request.output = folder / "out";
  request.views = 3;
  CHECK(WarpImages(request, kNeverStop));
  CHECK_FALSE(fs::exists(folder / "out/broken"));
  const ImageSource source = ReadHomographies(folder / "out/square");
  REQUIRE(source.scenes[0].pairs.size() == 3);
  for (const auto& pair : source.scenes[0].pairs) {
    // The bright square is where the matrix says.
    const Eigen::Vector2d at = (*pair.homography * Eigen::Vector3d(80, 60, 1)).hnormalized();
    const cv::Mat seen = cv::imread(source.images[pair.image2].path, cv::IMREAD_GRAYSCALE);
    REQUIRE(seen.size() == image.size());
    CHECK(seen.at<unsigned char>(static_cast<int>(at.y() + 0.5), static_cast<int>(at.x() + 0.5)) > 120);
  }
  // As a camera sees them they are others of the same homographies.
  const cv::Mat relit = cv::imread(folder / "out/square/2.png", cv::IMREAD_GRAYSCALE);
  const Eigen::Matrix3d view = *source.scenes[0].pairs[0].homography;
  request.photograph = true;
  CHECK(WarpImages(request, kNeverStop));
  const cv::Mat photographed = cv::imread(folder / "out/square/2.png", cv::IMREAD_GRAYSCALE);
  CHECK(photographed.size() == relit.size());
  CHECK(cv::countNonZero(photographed != relit) > 0);
  CHECK(*ReadHomographies(folder / "out/square").scenes[0].pairs[0].homography == view);
  request.input = folder / "nowhere";
  CHECK_THROWS_AS(WarpImages(request, kNeverStop), Error);
}

namespace {

// Grey with a bright disc in the middle.
cv::Mat Disc() {
  cv::Mat view(121, 161, CV_8U, cv::Scalar(60));
  cv::circle(view, {80, 60}, 20, cv::Scalar(200), cv::FILLED);
  return view;
}

}  // namespace

TEST_CASE("photograph: by its seed alone, of the view's size, and another one than the view") {
  const cv::Mat view = Disc(), once = Photograph(view, Rng(3)), again = Photograph(view, Rng(3));
  REQUIRE(once.size() == view.size());
  REQUIRE(once.type() == CV_8U);
  CHECK(cv::countNonZero(once != again) == 0);
  CHECK(cv::countNonZero(once != Photograph(view, Rng(4))) > 0);
  CHECK(view.at<unsigned char>(60, 80) == 200);
}

TEST_CASE("photograph: nothing moves, whatever the blur") {
  for (int seed = 0; seed < 30; ++seed) {
    const cv::Mat seen = Photograph(Disc(), Rng(seed));
    INFO(seed);
    // Darker or brighter, but the disc stays brighter than what is around it, and its centre where it was.
    cv::Mat bright;
    const double level = 0.5 * (seen.at<unsigned char>(60, 80) + seen.at<unsigned char>(60, 125));
    CHECK(seen.at<unsigned char>(60, 80) > seen.at<unsigned char>(60, 125) + 30);
    cv::GaussianBlur(seen, bright, {}, 2.0);
    const cv::Moments moments = cv::moments(bright(cv::Rect(40, 20, 81, 81)) > level, true);
    CHECK(40 + moments.m10 / moments.m00 == Approx(80.0).margin(1.0));
    CHECK(20 + moments.m01 / moments.m00 == Approx(60.0).margin(1.0));
  }
}

TEST_CASE("photograph: a black and a white view stay within the range of grey values") {
  for (const int grey : {0, 255}) {
    const cv::Mat seen = Photograph(cv::Mat(40, 50, CV_8U, cv::Scalar(grey)), Rng(1));
    CHECK(cv::mean(seen)[0] == Approx(grey).margin(grey == 0 ? 20.0 : 110.0));
  }
}

TEST_CASE("modelnet: virtual views as files, with what is true of them") {
  TemporaryFolder folder;
  fs::create_directories(folder / "meshes/train");
  // A tetrahedron and a box without its lid.
  const std::string tetrahedron = "OFF4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n";
  WriteRaw(folder / "meshes/train/tetra-1.off", tetrahedron);
  WriteRaw(folder / "meshes/broken.off", "OFF\n3 1 0\n0 0 0\n");
  ModelnetRequest request;
  request.input = folder / "meshes";
  request.output = folder / "out";
  request.pairs = 6;
  request.points = 60;
  request.outlier_ratio = {0.25};
  request.threads = 2;
  PrepareResult result = WriteModelnetPairs(request, kNeverStop);
  CHECK(result.written == 1);
  REQUIRE(result.left_out.size() == 1);
  CHECK(Has(result.left_out[0], "broken.off"));
  const CorrespondenceScene scene(folder / "out/modelnet40");
  REQUIRE(scene.size() == 3);
  CHECK(Has(scene.pairs()[0], "tetra_1_1-"));
  for (int i = 0; i < 3; ++i) {
    const Example pair = scene.Read(i);
    REQUIRE(pair.problem.points.rows() == 60);
    CHECK(pair.problem.cameras);
    CHECK(pair.problem.size1.width == 640);
    const Eigen::VectorXd distances = TruthDistances(pair.problem, pair.truth);
    int inliers = 0;
    for (Eigen::Index k = 0; k < 60; ++k) {
      if (pair.truth.assignment[k] == 0) continue;
      inliers += 1;
      CHECK(distances[k] < 1.5);
    }
    CHECK(inliers == 45);
  }
  CHECK(WriteModelnetPairs(request, kNeverStop).already_there == 1);
  request.overwrite = true;
  request.threads = 1;
  const PointMatrix before = scene.Read(2).problem.points;
  REQUIRE(WriteModelnetPairs(request, kNeverStop).written == 1);
  CHECK(CorrespondenceScene(folder / "out/modelnet40").Read(2).problem.points == before);
  request.subset = "train";
  REQUIRE(WriteModelnetPairs(request, kNeverStop).left_out.empty());
  CHECK(CorrespondenceScene(folder / "out/modelnet40").size() == 6);
  const std::atomic<bool> stop{true};
  request.scene = "stopped";
  CHECK(!WriteModelnetPairs(request, stop).finished);
  CHECK(!fs::exists(folder / "out/stopped"));

  const auto error = [&](auto change) {
    ModelnetRequest wrong = request;
    change(wrong);
    return ErrorOf([&] { WriteModelnetPairs(wrong, kNeverStop); });
  };
  CHECK(Has(error([](auto& r) { r.pairs = 0; }), "--pairs"));
  CHECK(Has(error([](auto& r) { r.outlier_ratio = {1.0}; }), "--outlier-ratio"));
  CHECK(Has(error([](auto& r) { r.outlier_ratio = {0.5, 0.1}; }), "--outlier-ratio"));
  CHECK(Has(error([](auto& r) { r.outlier_ratio = {}; }), "--outlier-ratio"));
  CHECK(Has(error([&](auto& r) { r.input = folder / "nowhere"; }), "nowhere"));
  CHECK(Has(error([&](auto& r) { r.subset = "test"; }), "test"));
  CHECK(Has(error([&](auto& r) { r.input = folder / "meshes/broken.off", r.subset = ""; }), "broken.off"));
}

}  // namespace diffsac
