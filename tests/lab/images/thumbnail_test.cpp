#include "lab/images/thumbnail.h"

#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/errors.h"
#include "lab/files/thumbnails.h"
#include "lab/images/image_test_util.h"

namespace diffsac {
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
  LensCamera plain, bent;
  plain.K = bent.K = Calibration(600, 600, 400, 300);
  bent.k1 = -0.25;
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
