#include "lab/images/match_picture.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/errors.h"
#include "lab/images/image_test_util.h"

namespace diffsac {

namespace fs = std::filesystem;

TEST_CASE("a picture of matches has the sizes and colours that it should have") {
  TemporaryFolder folder;
  Example pair = SyntheticSet(1, 60, Rng(4)).pairs[0];
  const std::string path = folder / "p.png";
  PictureCounts counts = DrawMatches(pair, 1.0, "", path);
  CHECK(counts.matches == 60);
  CHECK(counts.inliers >= 40);
  cv::Mat picture = cv::imread(path);
  CHECK(picture.size() == cv::Size(640 + 8 + 600, 480 + 36));
  const auto near = [&](const cv::Vec3b& color) {
    int pixels = 0;
    for (int y = 0; y < 480; ++y)
      for (int x = 0; x < picture.cols; ++x) pixels += cv::norm(picture.at<cv::Vec3b>(y, x), color, cv::NORM_L1) < 30;
    return pixels;
  };
  const cv::Vec3b green(115, 200, 0), orange(0, 110, 240), blue(230, 150, 40);
  CHECK((near(green) > 400 && near(orange) > 200 && near(blue) == 0));
  // The first inlier's point is green where it lies.
  const Eigen::Vector4d point = pair.problem.points.row(1);
  CHECK(picture.at<cv::Vec3b>(static_cast<int>(std::lround(point[1])), static_cast<int>(std::lround(point[0]))) ==
        green);

  // Without a model, labels decide; without labels nothing is known.
  pair.truth.fundamental.reset();
  pair.truth.essential.reset();
  pair.truth.motion.reset();
  CHECK(DrawMatches(pair, 1.0, "", path).inliers == 40);
  pair.truth.assignment.clear();
  CHECK(DrawMatches(pair, 1.0, "", path).inliers == -1);
  picture = cv::imread(path);
  CHECK((near(green) == 0 && near(blue) > 400));

  // Images, one of them large: reduced together. Points that are no numbers or far away do no harm.
  fs::create_directories(folder / "all/images");
  WriteImage(folder / "all/images/im_000.png", Texture(4000, 1000, 1));
  WriteImage(folder / "all/im_001.png", Texture(1000, 2000, 2));
  pair.problem.points(0, 0) = std::nan("");
  pair.problem.points(1, 2) = 1e12;
  DrawMatches(pair, 1.0, folder / "all", path);
  picture = cv::imread(path);
  CHECK((picture.cols >= 2398 && picture.cols <= 2401));
  CHECK(std::abs(picture.rows - (2000 * 2392 / 5000 + 36)) <= 1);

  CHECK(Has(ErrorOf([&] { DrawMatches(pair, 1.0, folder / "none", path); }), "none: no such folder"));
  CHECK(Has(ErrorOf([&] { DrawMatches(pair, 1.0, folder.path(), path); }), "there is no image im_000"));
  CHECK(Has(ErrorOf([&] { DrawMatches(pair, 1.0, "", folder / "no/p.png"); }), "no/p.png"));
  pair.problem.size2 = {};
  CHECK(Has(ErrorOf([&] { DrawMatches(pair, 1.0, "", path); }), "sizes.h5"));
  // No matches at all.
  pair.problem.size2 = {100, 100};
  pair.problem.points.resize(0, 4);
  CHECK(DrawMatches(pair, 1.0, "", path).matches == 0);
  CHECK(cv::imread(path).size() == cv::Size(748, 516));
}

}  // namespace diffsac
