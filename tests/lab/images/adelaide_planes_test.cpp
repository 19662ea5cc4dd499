#include "lab/images/adelaide_planes.h"

#include <catch2/catch.hpp>
#include <cstdio>

#include "core/errors.h"
#include "diffsac/geometry/homography.h"
#include "lab/images/image_test_util.h"
#include "lab/truth/pair_truth.h"

namespace diffsac {
namespace {

std::string Numbers(std::initializer_list<double> values) {
  std::string text;
  char number[40];
  for (double value : values) {
    std::snprintf(number, sizeof(number), "%.12g ", value);
    text += number;
  }
  return text;
}

// Labelled and tentative matches of two planes in images of 640 × 480 pixels, `others` of them of the second, which
// moves otherwise; those of the first lie within `extent` pixels of the corner and are noisy by `noise` in the second
// image. F is that of a translation.
struct House {
  int others = 10;
  double extent = 500.0;
  double noise = 0.0;
  void Write(const TemporaryFolder& folder, const std::string& name) const {
    std::string labelled, tentative, scores;
    int count = 0;
    Rng rng(7);
    const auto add = [&](double size, double shift, double error, int label) {
      const double x = rng.Uniform(0.0, size), y = rng.Uniform(0.0, 0.8 * size);
      labelled += Numbers({x, y, 1, x + shift + error, y, 1}) + std::to_string(label) + "\n";
      tentative += Numbers({x, y, x + shift + error, y}) + "\n";
      scores += "0.5\n";
      ++count;
    };
    for (int i = 0; i < 40; ++i) add(extent, 40.0, noise * rng.Normal(), 1);
    for (int i = 0; i < others; ++i) add(500.0, -300.0, 0.0, 2);
    WriteRaw(folder / (name + "_model.txt"), "0 0 0\n0 0 -1\n0 1 0\n");
    WriteRaw(folder / (name + "_pts.txt"), labelled);
    WriteRaw(folder / ("sift_update/" + name + "_pts.txt"), std::to_string(count) + "\n" + tentative);
    WriteRaw(folder / ("sift_update/" + name + "_score.txt"), scores);
    const cv::Mat grey(480, 640, CV_8U, cv::Scalar(7));
    WriteImage(folder / (name + "A.png"), grey);
    WriteImage(folder / (name + "B.png"), grey);
  }
};

}  // namespace

TEST_CASE("AdelaideRMF's planes: the homography of the dominant one, of every other pair") {
  TemporaryFolder folder;
  MakeFolder(folder / "sift_update");
  House{}.Write(folder, "a");
  House{}.Write(folder, "b");
  House{}.Write(folder, "c");
  const CorrespondenceSet even = ReadAdelaidePlanes(folder.path(), 0), odd = ReadAdelaidePlanes(folder.path(), 1);
  REQUIRE(even.pairs.size() == 2);
  REQUIRE(odd.pairs.size() == 1);
  CHECK(even.pairs[1].id == "cA-cB");
  CHECK(odd.pairs[0].id == "bA-bB");
  const Example& pair = even.pairs[0];
  REQUIRE(pair.truth.homography);
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift(0, 2) = 40.0;
  CHECK((*pair.truth.homography / (*pair.truth.homography)(2, 2) - shift).norm() < 1e-6);
  // Not both: which plane is meant is the homography's to say.
  CHECK_FALSE(pair.truth.fundamental);
  CHECK(pair.problem.match_ratio.size() == 50);
  CHECK((TruthDistances(pair.problem, pair.truth).array() < 1e-6).count() == 40);
}

TEST_CASE("AdelaideRMF's planes: pairs of two planes alike, or of an uncertain one, are left out") {
  TemporaryFolder folder;
  MakeFolder(folder / "sift_update");
  House{.others = 26}.Write(folder, "a");
  CHECK(ReadAdelaidePlanes(folder.path(), 0).pairs.size() == 1);
  House{.others = 28}.Write(folder, "a");
  CHECK(ReadAdelaidePlanes(folder.path(), 0).pairs.empty());
  // In a corner, exact labels still say where the rest of the image goes, noisy ones do not.
  House{.extent = 30.0}.Write(folder, "a");
  CHECK(ReadAdelaidePlanes(folder.path(), 0).pairs.size() == 1);
  House{.extent = 30.0, .noise = 1.0}.Write(folder, "a");
  CHECK(ReadAdelaidePlanes(folder.path(), 0).pairs.empty());
}

TEST_CASE("a labelled plane's fit ignores wrong labels, and needs eight matches that determine one") {
  Rng rng(3);
  PointMatrix matches(40, 4);
  for (int i = 0; i < 40; ++i) {
    const double x = rng.Uniform(0.0, 600.0), y = rng.Uniform(0.0, 400.0);
    const double w = 1.0 + 2e-4 * x;
    matches.row(i) << x, y, (1.1 * x + 20.0) / w, (0.9 * y - 10.0) / w;
  }
  for (int i : {3, 17}) matches(i, 2) += 4.0;
  const auto model = FitLabelledPlane(matches);
  REQUIRE(model);
  for (int i = 0; i < 40; ++i)
    if (i != 3 && i != 17) CHECK(HomographySampsonError(*model, matches.row(i).data()) < 0.01);
  CHECK_FALSE(FitLabelledPlane(matches.topRows(7)));
  CHECK_FALSE(FitLabelledPlane(PointMatrix::Zero(20, 4)));
}

}  // namespace diffsac
