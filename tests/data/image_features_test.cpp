#include "data_tools/image_features.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "data_test_util.h"
#include "image_test_util.h"

namespace diffsac {
namespace {

DescriptorMatrix RandomUnitRows(int rows, int cols, Rng rng) {
  DescriptorMatrix matrix(rows, cols);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < cols; ++j) matrix(i, j) = static_cast<float>(std::abs(rng.Normal()));
    matrix.row(i).normalize();
  }
  return matrix;
}

// The definition, by all distances in double precision.
std::vector<DescriptorMatch> MatchByDefinition(const DescriptorMatrix& first, const DescriptorMatrix& second) {
  const auto distance = [&](Eigen::Index i, Eigen::Index j) {
    return (first.row(i).cast<double>() - second.row(j).cast<double>()).norm();
  };
  std::vector<DescriptorMatch> matches;
  for (int i = 0; i < first.rows(); ++i) {
    std::vector<std::pair<double, int>> sorted;
    for (int j = 0; j < second.rows(); ++j) sorted.push_back({distance(i, j), j});
    std::sort(sorted.begin(), sorted.end());
    const int nearest = sorted[0].second;
    int back = 0;
    for (int k = 1; k < first.rows(); ++k)
      if (distance(k, nearest) < distance(back, nearest)) back = k;
    if (back == i) matches.push_back({i, nearest, sorted.size() > 1 ? sorted[0].first / sorted[1].first : 1.0});
  }
  return matches;
}

}  // namespace

TEST_CASE("mutual matches are those of the definition") {
  // More rows than one block of the product, and the smallest cases.
  for (const auto& [n1, n2] : {std::pair(600, 300), std::pair(1, 1), std::pair(1, 5), std::pair(5, 1)}) {
    const DescriptorMatrix first = RandomUnitRows(n1, 16, Rng(1).Fork("first", n1));
    const DescriptorMatrix second = RandomUnitRows(n2, 16, Rng(1).Fork("second", n2));
    const auto expected = MatchByDefinition(first, second);
    const auto matches = MatchMutually(first, second);
    REQUIRE(matches.size() == expected.size());
    for (std::size_t i = 0; i < matches.size(); ++i) {
      CHECK(matches[i].first == expected[i].first);
      CHECK(matches[i].second == expected[i].second);
      CHECK(matches[i].ratio == Approx(expected[i].ratio).epsilon(1e-9));
    }
  }
  CHECK(MatchMutually(DescriptorMatrix(0, 16), DescriptorMatrix::Ones(3, 16)).empty());
  CHECK(MatchMutually(DescriptorMatrix::Ones(3, 16), DescriptorMatrix(0, 16)).empty());
}

TEST_CASE("equal rows have one match and the worst ratio") {
  DescriptorMatrix same = DescriptorMatrix::Constant(4, 16, 0.25f);
  const auto matches = MatchMutually(same, same);
  REQUIRE(matches.size() == 1);
  CHECK(matches[0].first == 0);
  CHECK(matches[0].second == 0);
  CHECK(matches[0].ratio == 1.0);
}

TEST_CASE("keypoints are found where they are, strongest first, with unit descriptors") {
  TemporaryFolder folder;
  const cv::Mat texture = Texture(320, 240, 1);
  WriteImage(folder / "a.png", texture);
  const ImageFeatures all = ExtractRootSift(folder / "a.png", {});
  CHECK(all.size == ImageSize{320, 240});
  CHECK(ReadImageSize(folder / "a.png") == all.size);
  REQUIRE(all.positions.rows() > 100);
  CHECK(all.descriptors.rows() == all.positions.rows());
  CHECK(all.descriptors.cols() == 128);
  CHECK((all.descriptors.rowwise().norm().array() - 1.0f).abs().maxCoeff() < 1e-5f);
  CHECK(all.descriptors.minCoeff() >= 0.0f);
  CHECK((all.positions.col(0).minCoeff() >= 0.0 && all.positions.col(0).maxCoeff() <= 319.0));
  CHECK((all.positions.col(1).minCoeff() >= 0.0 && all.positions.col(1).maxCoeff() <= 239.0));
  // The same again, and fewer are the first of all.
  const ImageFeatures again = ExtractRootSift(folder / "a.png", {});
  CHECK((again.positions == all.positions && again.descriptors == all.descriptors));
  FeatureOptions fewer;
  fewer.max_keypoints = 50;
  const ImageFeatures some = ExtractRootSift(folder / "a.png", fewer);
  REQUIRE(some.positions.rows() == 50);
  CHECK(some.positions == all.positions.topRows(50));
}

TEST_CASE("matches between an image and its warped copy follow the warp, at full and reduced size") {
  TemporaryFolder folder;
  const cv::Mat texture = Texture(480, 360, 2);
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> H;
  H << 0.95, -0.12, 30, 0.1, 1.02, -20, 1e-4, -5e-5, 1;
  cv::Mat warped;
  cv::warpPerspective(texture, warped, cv::Mat(3, 3, CV_64F, H.data()), texture.size());
  WriteImage(folder / "a.png", texture);
  WriteImage(folder / "b.png", warped);
  for (int max_size : {0, 400}) {
    FeatureOptions options;
    options.max_image_size = max_size;
    const ImageFeatures first = ExtractRootSift(folder / "a.png", options);
    const ImageFeatures second = ExtractRootSift(folder / "b.png", options);
    CHECK(first.size == ImageSize{480, 360});
    const auto matches = MatchMutually(first.descriptors, second.descriptors);
    TwoViewProblem problem;
    problem.points.resize(static_cast<Eigen::Index>(matches.size()), 4);
    for (std::size_t i = 0; i < matches.size(); ++i)
      problem.points.row(static_cast<Eigen::Index>(i)) << first.positions.row(matches[i].first),
          second.positions.row(matches[i].second);
    TwoViewTruth truth;
    truth.homography = H;
    const Eigen::VectorXd distances = TruthDistances(problem, truth);
    REQUIRE(distances.size() > 100);
    const double share = (distances.array() < 1.0).cast<double>().mean();
    CHECK(share > 0.7);
    // True matches stand out by their ratio.
    double sums[2] = {0, 0};
    int counts[2] = {0, 0};
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const int good = distances[static_cast<Eigen::Index>(i)] < 1.0 ? 1 : 0;
      sums[good] += matches[i].ratio;
      counts[good] += 1;
    }
    CHECK(sums[1] / counts[1] + 0.2 < sums[0] / counts[0]);
  }
}

TEST_CASE("images without texture have no keypoints, and files that are no images are named") {
  TemporaryFolder folder;
  WriteImage(folder / "flat.png", cv::Mat(64, 64, CV_8U, cv::Scalar(100)));
  const ImageFeatures flat = ExtractRootSift(folder / "flat.png", {});
  CHECK(flat.positions.rows() == 0);
  CHECK(MatchMutually(flat.descriptors, flat.descriptors).empty());
  WriteImage(folder / "tiny.png", cv::Mat(1, 1, CV_8U, cv::Scalar(100)));
  CHECK(ExtractRootSift(folder / "tiny.png", {}).positions.rows() == 0);
  WriteRaw(folder / "text.png", "no image");
  CHECK(Has(ErrorOf([&] { ExtractRootSift(folder / "text.png", {}); }), "text.png"));
  CHECK(Has(ErrorOf([&] { ExtractRootSift(folder / "missing.png", {}); }), "missing.png"));
  FeatureOptions bad;
  bad.max_keypoints = -1;
  CHECK(Has(ErrorOf([&] { ExtractRootSift(folder / "flat.png", bad); }), "max_keypoints"));
}

}  // namespace diffsac
