#include "lab/images/adelaide_rmf.h"

#include <catch2/catch.hpp>
#include <cstdio>

#include "core/errors.h"
#include "lab/images/image_test_util.h"
#include "lab/truth/pair_truth.h"

namespace diffsac {

TEST_CASE("AdelaideRMF: labels, tentative matches, a wrong F is fitted again") {
  TemporaryFolder folder;
  const Example pair = SyntheticSet(1, 60, Rng(9)).pairs[0];
  const PointMatrix& points = pair.problem.points;
  const auto number = [](double value) {
    char text[40];
    std::snprintf(text, sizeof(text), "%.12g ", value);
    return std::string(text);
  };
  std::string labelled, tentative = "60\n", scores;
  for (Eigen::Index i = 0; i < 60; ++i) {
    const std::string x1 = number(points(i, 0)) + number(points(i, 1)),
                      x2 = number(points(i, 2)) + number(points(i, 3));
    labelled += x1 + "1 " + x2 + "1 " + std::to_string(i % 3) + "\n";
    tentative += x1 + x2 + "\n";
    scores += number(pair.problem.match_ratio[i]) + "\n";
  }
  const auto write_model = [&](const Eigen::Matrix3d& F) {
    std::string text;
    for (int i = 0; i < 9; ++i) text += number(F(i / 3, i % 3)) + (i % 3 == 2 ? "\n" : "");
    WriteRaw(folder / "house_model.txt", text);
  };
  MakeFolder(folder / "sift_update");
  WriteSmall(folder / "houseA.png");
  WriteSmall(folder / "houseB.png");
  WriteRaw(folder / "house_pts.txt", labelled);
  WriteRaw(folder / "sift_update/house_pts.txt", tentative);
  WriteRaw(folder / "sift_update/house_score.txt", scores);
  const auto read = [&](AdelaideCorrespondences kind) { return ReadAdelaideRmf(folder.path(), kind).pairs.at(0); };
  const auto error = [&](AdelaideCorrespondences kind) { return ErrorOf([&] { read(kind); }); };

  write_model(*pair.truth.fundamental);
  const Example with_labels = read(AdelaideCorrespondences::kLabelled);
  CHECK(with_labels.id == "houseA-houseB");
  CHECK(with_labels.problem.size1 == ImageSize{10, 8});
  CHECK((with_labels.problem.points - points).cwiseAbs().maxCoeff() < 1e-8);
  CHECK(with_labels.truth.assignment[2] == 2);
  CHECK(with_labels.problem.match_ratio.size() == 0);
  CHECK((*with_labels.truth.fundamental - *pair.truth.fundamental).norm() < 1e-9);
  const Example with_ratio = read(AdelaideCorrespondences::kTentative);
  CHECK((with_ratio.problem.match_ratio - pair.problem.match_ratio).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(with_ratio.truth.assignment.empty());
  CHECK((with_ratio.problem.points - points).cwiseAbs().maxCoeff() < 1e-8);

  write_model(Eigen::Matrix3d(pair.truth.fundamental->transpose()));
  const Example refitted = read(AdelaideCorrespondences::kLabelled);
  const Eigen::VectorXd distances = TruthDistances(refitted.problem, refitted.truth);
  for (int i = 0; i < 60; ++i)
    if (i % 3 != 0) CHECK(distances[i] < 0.1);

  WriteRaw(folder / "sift_update/house_score.txt", "0.5\n");
  CHECK(Has(error(AdelaideCorrespondences::kTentative), "house_score.txt: expected 60 ratios"));
  WriteRaw(folder / "sift_update/house_pts.txt", "61\n1 2 3 4\n");
  CHECK(Has(error(AdelaideCorrespondences::kTentative), "number of rows"));
  WriteRaw(folder / "house_pts.txt", "1 2 1 3 4 1 0\n1 2 5 3 4 1 0\n");
  CHECK(Has(error(AdelaideCorrespondences::kLabelled), "house_pts.txt:2"));
  WriteRaw(folder / "house_pts.txt", "1 2 1 3 4 1 1\n1 2 1 30 4 1 1\n");
  CHECK(Has(error(AdelaideCorrespondences::kLabelled), "house_model.txt"));
  TemporaryFolder empty;
  CHECK(Has(ErrorOf([&] { ReadAdelaideRmf(empty.path(), AdelaideCorrespondences::kLabelled); }), "_model.txt"));
}

}  // namespace diffsac
