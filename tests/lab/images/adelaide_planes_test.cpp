#include "lab/images/adelaide_planes.h"

#include <catch2/catch.hpp>
#include <vector>

#include "core/errors.h"
#include "diffsac/core/random.h"
#include "diffsac/geometry/homography.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {
namespace {

// Labelled and tentative matches of two planes in images of 640 × 480 pixels, `others` of them of the second, which
// moves otherwise; those of the first lie within `extent` pixels of the corner and are noisy by `noise` in the second
// image. F is that of a translation.
struct House {
  int others = 10;
  double extent = 500.0;
  double noise = 0.0;

  // With labels, or as tentative matches.
  Example Pair(const std::string& name, bool labels) const {
    Example pair;
    pair.image1 = name + "A";
    pair.image2 = name + "B";
    pair.id = pair.image1 + "-" + pair.image2;
    Problem& problem = pair.problem;
    problem.size1 = problem.size2 = {640, 480};
    problem.points.resize(40 + others, 4);
    Rng rng(7);
    const auto set = [&](int row, double size, double shift, double error) {
      const double x = rng.Uniform(0.0, size), y = rng.Uniform(0.0, 0.8 * size);
      problem.points.row(row) << x, y, x + shift + error, y;
      if (labels) pair.truth.assignment.push_back(row < 40 ? 1 : 2);
    };
    for (int i = 0; i < 40; ++i) set(i, extent, 40.0, noise * rng.Normal());
    for (int i = 0; i < others; ++i) set(40 + i, 500.0, -300.0, 0.0);
    if (!labels) problem.snn_ratio = Eigen::VectorXd::Constant(40 + others, 0.5);
    pair.truth.fundamental.emplace();
    *pair.truth.fundamental << 0, 0, 0, 0, 0, -1, 0, 1, 0;
    return pair;
  }
  void Write(const TemporaryFolder& folder, const std::vector<std::string>& names) const {
    for (const bool labels : {true, false}) {
      CorrespondenceSet set;
      for (const std::string& name : names) set.pairs.push_back(Pair(name, labels));
      WriteCorrespondences(folder / (labels ? "adelaidermf" : "adelaidermf_sift"), set);
    }
  }
};

}  // namespace

TEST_CASE("AdelaideRMF's planes: the homography of the dominant one, of every other pair") {
  TemporaryFolder folder;
  House{}.Write(folder, {"a", "b", "c"});
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
  CHECK(pair.problem.snn_ratio.size() == 50);
  CHECK((TruthDistances(pair.problem, pair.truth).array() < 1e-6).count() == 40);
}

TEST_CASE("AdelaideRMF's planes: pairs of two planes alike, or of an uncertain one, are left out") {
  TemporaryFolder folder;
  House{.others = 26}.Write(folder, {"a"});
  CHECK(ReadAdelaidePlanes(folder.path(), 0).pairs.size() == 1);
  House{.others = 28}.Write(folder, {"a"});
  CHECK(ReadAdelaidePlanes(folder.path(), 0).pairs.empty());
  // In a corner, exact labels still say where the rest of the image goes, noisy ones do not.
  House{.extent = 30.0}.Write(folder, {"a"});
  CHECK(ReadAdelaidePlanes(folder.path(), 0).pairs.size() == 1);
  House{.extent = 30.0, .noise = 1.0}.Write(folder, {"a"});
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
