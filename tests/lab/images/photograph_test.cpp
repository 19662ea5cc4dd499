#include "lab/images/photograph.h"

#include <catch2/catch.hpp>
#include <opencv2/imgproc.hpp>

namespace diffsac {
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

}  // namespace diffsac
