#include <catch2/catch.hpp>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/errors.h"
#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/images/image_test_util.h"
#include "lab/images/pictures.h"

namespace diffsac {

namespace {

VanishingPointsEstimate Found() {
  VanishingPointsEstimate estimate;
  estimate.status = Status::kOk;
  estimate.points = {{300.0, 50.0, 1.0}, {0.0, 1.0, 0.0}};
  estimate.assignment = {1, 2, 0};
  return estimate;
}

PointMatrix Segments() {
  PointMatrix segments(3, 4);
  segments << 20, 40, 120, 40, 200, 100, 200, 180, 20, 180, 100, 190;
  return segments;
}

cv::Vec3b At(const cv::Mat& picture, int x, int y) { return picture.at<cv::Vec3b>(y, x); }

// Blue, green, red.
const cv::Vec3b kFirst(0xB2, 0x72, 0x00), kSecond(0x00, 0x5E, 0xD5);

}  // namespace

TEST_CASE("segments have the colour of their vanishing point, which has a ring, and others are grey") {
  const cv::Mat gray(240, 400, CV_8U, cv::Scalar(255));
  const cv::Mat picture = DrawVanishingPoints(gray, Segments(), Found());
  CHECK(picture.cols == 400);
  CHECK(picture.rows > 240);
  CHECK(At(picture, 70, 40) == kFirst);
  CHECK(At(picture, 200, 140) == kSecond);
  CHECK(At(picture, 309, 50) == kFirst);
  CHECK(At(picture, 300, 200)[0] > 200);
  const cv::Vec3b other = At(picture, 60, 185);
  CHECK(other[0] == other[2]);
  CHECK(other[0] < 200);
}

TEST_CASE("the horizon is drawn where it is in the picture") {
  const cv::Mat gray(240, 400, CV_8U, cv::Scalar(255));
  VanishingPointsEstimate estimate = Found();
  const auto dark_rows = [&](double row) {
    estimate.horizon.emplace().line = {0.0, 1.0, -row};
    const cv::Mat picture = DrawVanishingPoints(gray, Segments(), estimate);
    int count = 0;
    for (int x = 0; x < 400; ++x) count += At(picture, x, 140) == cv::Vec3b(0, 0, 0);
    return count;
  };
  CHECK(dark_rows(140.0) > 150);
  CHECK(dark_rows(60.0) == 0);
  CHECK(dark_rows(-1e7) == 0);
}

TEST_CASE("large images become smaller, and nothing at all is a picture too") {
  const cv::Mat large(1000, 3200, CV_8U, cv::Scalar(90));
  const cv::Mat picture = DrawVanishingPoints(large, PointMatrix(0, 4), {});
  CHECK(picture.cols == 1600);
  const cv::Mat narrow(900, 40, CV_8U, cv::Scalar(90));
  CHECK(DrawVanishingPoints(narrow, Segments(), Found()).cols == 40);
}

TEST_CASE("a picture's name says its format, and a wrong one writes nothing") {
  const TemporaryFolder folder;
  const cv::Mat image(10, 10, CV_8UC3, cv::Scalar(1, 2, 3));
  WritePicture(image, folder.File("a.png"));
  CHECK(std::filesystem::file_size(folder.File("a.png")) > 20);
  CHECK_THROWS_WITH(CheckPictureName("a"), "a: expected a name that ends in .png, .jpg or another format of pictures");
  CHECK_THROWS_AS(WritePicture(image, folder.File("a.xyz")), Error);
  CHECK_FALSE(std::filesystem::exists(folder.File("a.xyz")));
}

namespace {

cv::Mat Decoded(const std::string& bytes) {
  return cv::imdecode(std::vector<unsigned char>(bytes.begin(), bytes.end()), cv::IMREAD_GRAYSCALE);
}

/// The mean difference of grey values away from the border, which a lens may push out of the picture.
double Difference(const cv::Mat& a, const cv::Mat& b) {
  const cv::Rect inner(a.cols / 5, a.rows / 5, a.cols * 3 / 5, a.rows * 3 / 5);
  cv::Mat difference;
  cv::absdiff(a(inner), b(inner), difference);
  return cv::mean(difference)[0];
}

TEST_CASE("a small copy has no distortion of the lens and at most 640 pixels a side") {
  const TemporaryFolder folder;
  const cv::Mat texture = Texture(900, 700, 5);
  const LensCamera plain = CameraOfColmap({0, {}, {600, 400.5, 300.5}}, "here"),
                   bent = CameraOfColmap({2, {}, {600, 400.5, 300.5, -0.25}}, "here");
  const ImageSize size{800, 600};
  const RigidMotion pose = NearbyPose(0);
  const cv::Mat straight = Render(texture, plain, pose, size);
  WriteImage(folder / "bent.png", Render(texture, bent, pose, size));
  WriteImage(folder / "straight.png", straight);
  cv::Mat expected;
  cv::resize(straight, expected, {640, 480}, 0, 0, cv::INTER_AREA);
  const auto of = [&](const std::string& name, const std::optional<LensCamera>& camera) {
    return Decoded(ThumbnailOf({name, folder / name, camera, {}, -1}));
  };
  REQUIRE(of("bent.png", bent).size() == cv::Size(640, 480));
  CHECK(Difference(of("bent.png", bent), expected) < 6.0);
  CHECK(Difference(of("straight.png", {}), expected) < 3.0);
  CHECK(Difference(of("bent.png", {}), expected) > 2.0 * Difference(of("bent.png", bent), expected));
  CHECK(ThumbnailOf({"none", folder / "none.png", {}, {}, -1}).empty());
}

}  // namespace

}  // namespace diffsac
