#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <set>

#include "core/errors.h"
#include "lab/files/files.h"
#include "lab/images/detection.h"
#include "lab/images/feature_store.h"
#include "lab/images/image_features.h"
#include "lab/images/image_test_util.h"
#include "lab/images/match_pair.h"

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
  const ImageFeatures all = ExtractFeatures(folder / "a.png", {});
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
  const ImageFeatures again = ExtractFeatures(folder / "a.png", {});
  CHECK((again.positions == all.positions && again.descriptors == all.descriptors));
  FeatureOptions fewer;
  fewer.max_keypoints = 50;
  const ImageFeatures some = ExtractFeatures(folder / "a.png", fewer);
  REQUIRE(some.positions.rows() == 50);
  CHECK(some.positions == all.positions.topRows(50));
}

TEST_CASE("a large image has the keypoints that its whole has, though they are found in tiles") {
  TemporaryFolder folder;
  cv::Mat coarse, image;
  cv::resize(Texture(260, 180, 5), coarse, cv::Size(2080, 1440));
  cv::addWeighted(Texture(2080, 1440, 6), 2.0, coarse, 2.0, -3.0 * 128.0, image);
  WriteImage(folder / "a.png", image);
  FeatureOptions options;
  const RawFeatures found = ExtractRawFeatures(folder / "a.png", options);
  std::vector<cv::KeyPoint> whole;
  cv::Mat raw;
  MakeDetector(options)->detectAndCompute(image, cv::noArray(), whole, raw);
  REQUIRE(whole.size() > 2000);
  CHECK(found.positions.rows() <= options.max_keypoints);
  CHECK(std::abs(found.positions.rows() - static_cast<int>(whole.size())) < 0.02 * static_cast<double>(whole.size()));

  ByteMatrix bytes(1, raw.cols);
  int same[2] = {0, 0}, all[2] = {0, 0};
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const Eigen::RowVector2d place(whole[i].pt.x, whole[i].pt.y);
    const bool fine = static_cast<std::int8_t>(whole[i].octave & 0xFF) < 2;
    CopyBytes(raw, static_cast<int>(i), 0, &bytes);
    const double reach = fine ? 1e-3 : 0.1 * whole[i].size;
    bool seen = false;
    for (Eigen::Index j = 0; j < found.positions.rows() && !seen; ++j)
      seen = (found.positions.row(j) - place).norm() < reach &&
             std::abs(found.frames(j, 0) - std::log(whole[i].size)) < (fine ? 1e-6 : 0.15) &&
             (!fine || found.bytes.row(j) == bytes.row(0));
    ++all[fine ? 0 : 1];
    same[fine ? 0 : 1] += seen ? 1 : 0;
  }
  CHECK(same[0] >= 0.999 * all[0]);
  REQUIRE(all[1] > 100);
  CHECK(same[1] > 0.7 * all[1]);
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
    const ImageFeatures first = ExtractFeatures(folder / "a.png", options);
    const ImageFeatures second = ExtractFeatures(folder / "b.png", options);
    CHECK(first.size == ImageSize{480, 360});
    const auto matches = MatchMutually(first.descriptors, second.descriptors);
    Problem problem;
    problem.points.resize(static_cast<Eigen::Index>(matches.size()), 4);
    for (std::size_t i = 0; i < matches.size(); ++i)
      problem.points.row(static_cast<Eigen::Index>(i)) << first.positions.row(matches[i].first),
          second.positions.row(matches[i].second);
    GroundTruth truth;
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

TEST_CASE("an image turned and enlarged has keypoints turned and enlarged as much") {
  TemporaryFolder folder;
  const cv::Mat texture = Texture(300, 300, 4);
  const double scale = 1.5, angle = 0.6;
  // x2 = s R(θ) (x1 − c) + c2, θ from the x axis towards the y axis.
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> warp;
  warp << scale * std::cos(angle), -scale * std::sin(angle), 0.0, scale * std::sin(angle), scale * std::cos(angle), 0.0;
  warp.col(2) = Eigen::Vector2d(350.0, 350.0) - warp.leftCols<2>() * Eigen::Vector2d(150.0, 150.0);
  cv::Mat warped;
  cv::warpAffine(texture, warped, cv::Mat(2, 3, CV_64F, warp.data()), cv::Size(700, 700), cv::INTER_CUBIC);
  WriteImage(folder / "a.png", texture);
  WriteImage(folder / "b.png", warped);
  for (FeatureKind kind : {FeatureKind::kRootSift, FeatureKind::kOrb}) {
    // Sizes are those in the file's pixels.
    for (int max_size : {0, 500}) {
      CAPTURE(ToString(kind), max_size);
      FeatureOptions options;
      options.kind = kind;
      options.max_image_size = max_size;
      ImageSource source;
      for (const char* name : {"a", "b"})
        source.images.push_back({name, folder / (name + std::string(".png")), {}, {}});
      const ImageFeatures first = ExtractFeatures(source.images[0].path, options);
      const ImageFeatures second = ExtractFeatures(source.images[1].path, options);
      const Problem problem = MatchPair(source, {0, 1, {}}, first, second, DistanceOf(kind)).example.problem;
      REQUIRE(problem.scale_rotation_changes.rows() == problem.points.rows());
      std::vector<double> scales, turns;
      for (Eigen::Index i = 0; i < problem.points.rows(); ++i) {
        const Eigen::Vector2d expected = warp.leftCols<2>() * problem.points.row(i).head<2>().transpose() + warp.col(2);
        if ((expected - problem.points.row(i).tail<2>().transpose()).norm() > 1.5) continue;
        scales.push_back(problem.scale_rotation_changes(i, 0) - std::log(scale));
        turns.push_back(std::remainder(problem.scale_rotation_changes(i, 1) - angle, 2.0 * std::numbers::pi));
      }
      REQUIRE(scales.size() > 50);
      std::sort(scales.begin(), scales.end());
      std::sort(turns.begin(), turns.end());
      CHECK(std::abs(scales[scales.size() / 2]) < 0.1);
      CHECK(std::abs(turns[turns.size() / 2]) < 0.05);
      CHECK(turns[turns.size() * 3 / 4] - turns[turns.size() / 4] < 0.2);
    }
  }
}

TEST_CASE("bits are matched by their Hamming distance") {
  Rng rng(5);
  for (const auto& [n1, n2] : {std::pair(300, 120), std::pair(1, 3)}) {
    DescriptorMatrix first(n1, 256), second(n2, 256);
    for (DescriptorMatrix* rows : {&first, &second})
      for (Eigen::Index i = 0; i < rows->size(); ++i) rows->data()[i] = rng.Uniform() < 0.5 ? 1.0f : 0.0f;
    const auto distance = [&](Eigen::Index i, Eigen::Index j) { return (first.row(i) - second.row(j)).squaredNorm(); };
    const auto matches = MatchMutually(first, second, DescriptorDistance::kHamming);
    REQUIRE(!matches.empty());
    for (const DescriptorMatch& match : matches) {
      float best = 1e9f, next = 1e9f;
      for (Eigen::Index j = 0; j < n2; ++j) {
        const float d = distance(match.first, j);
        if (d < best)
          next = best, best = d;
        else
          next = std::min(next, d);
      }
      CHECK(distance(match.first, match.second) == best);
      CHECK(match.ratio == Approx(best / next));
      for (Eigen::Index i = 0; i < n1; ++i) CHECK(distance(i, match.second) >= best);
    }
  }
}

TEST_CASE("ORB finds the same places in a warped image, on all of its scales") {
  TemporaryFolder folder;
  const cv::Mat texture = Texture(640, 480, 2);
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> H;
  // Half the size: keypoints lie on different scales of the two images.
  H << 0.5, 0, -0.25, 0, 0.5, -0.25, 0, 0, 1;
  cv::Mat half;
  cv::resize(texture, half, cv::Size(), 0.5, 0.5, cv::INTER_AREA);
  WriteImage(folder / "a.png", texture);
  WriteImage(folder / "b.png", half);
  FeatureOptions options;
  options.kind = FeatureKind::kOrb;
  const ImageFeatures first = ExtractFeatures(folder / "a.png", options);
  const ImageFeatures second = ExtractFeatures(folder / "b.png", options);
  CHECK(first.descriptors.cols() == 256);
  options.max_keypoints = 40;
  CHECK(ExtractFeatures(folder / "a.png", options).positions.rows() <= 40);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int near = 0;
  for (const DescriptorMatch& match :
       MatchMutually(first.descriptors, second.descriptors, DescriptorDistance::kHamming)) {
    const Eigen::Vector2d there = (H * first.positions.row(match.first).transpose().homogeneous()).hnormalized();
    const Eigen::Vector2d error = second.positions.row(match.second).transpose() - there;
    if (error.norm() > 2.0) continue;
    near += 1;
    sum += error;
  }
  REQUIRE(near > 100);
  // No drift to one side between scales.
  CHECK((sum / near).cwiseAbs().maxCoeff() < 0.15);
}

TEST_CASE("twelve bits of sixteen, and values with a floating point, are as bright as eight bits") {
  TemporaryFolder folder;
  const cv::Mat bytes = Texture(160, 120, 1);
  const auto scaled = [&](int type, double factor, double added = 0.0) {
    cv::Mat image;
    bytes.convertTo(image, type, factor, added);
    return image;
  };
  WriteImage(folder / "12.png", scaled(CV_16U, 16.0));
  WriteImage(folder / "10.tif", scaled(CV_16U, 4.0));
  WriteImage(folder / "16.png", scaled(CV_16U, 257.0));
  WriteImage(folder / "light.tif", scaled(CV_32F, 1.0 / 255.0));
  WriteImage(folder / "bytes.tif", scaled(CV_32F, 1.0));
  for (const char* name : {"12.png", "10.tif", "16.png", "light.tif", "bytes.tif"}) {
    CAPTURE(name);
    CHECK(cv::norm(ReadGrayImage(folder / name), bytes, cv::NORM_INF) <= 1.0);
  }
  // Of another range, from the least to the greatest; a value that is none is dark.
  cv::Mat heights = scaled(CV_32F, -3.0, 1000.0);
  heights.at<float>(0, 0) = std::nanf("");
  WriteImage(folder / "heights.tif", heights);
  const cv::Mat read = ReadGrayImage(folder / "heights.tif");
  double low = 0.0, high = 0.0;
  cv::minMaxLoc(read, &low, &high);
  CHECK((low == 0.0 && high == 255.0));
  CHECK(read.at<unsigned char>(0, 0) == 0);
  WriteImage(folder / "none.tif", cv::Mat(8, 8, CV_32F, cv::Scalar(std::nan(""))));
  CHECK(Has(ErrorOf([&] { ReadGrayImage(folder / "none.tif"); }), "none.tif: no value of it is finite"));
}

TEST_CASE("images without texture have no keypoints, and files that are no images are named") {
  TemporaryFolder folder;
  WriteImage(folder / "flat.png", cv::Mat(64, 64, CV_8U, cv::Scalar(100)));
  const ImageFeatures flat = ExtractFeatures(folder / "flat.png", {});
  CHECK(flat.positions.rows() == 0);
  CHECK(MatchMutually(flat.descriptors, flat.descriptors).empty());
  WriteImage(folder / "tiny.png", cv::Mat(1, 1, CV_8U, cv::Scalar(100)));
  CHECK(ExtractFeatures(folder / "tiny.png", {}).positions.rows() == 0);
  WriteRaw(folder / "text.png", "no image");
  CHECK(Has(ErrorOf([&] { ExtractFeatures(folder / "text.png", {}); }), "text.png"));
  CHECK(Has(ErrorOf([&] { ExtractFeatures(folder / "missing.png", {}); }), "missing.png"));
  FeatureOptions bad;
  bad.max_keypoints = -1;
  CHECK(Has(ErrorOf([&] { ExtractFeatures(folder / "flat.png", bad); }), "max_keypoints"));
}

TEST_CASE("keypoints in files are read back as they were, others are not taken") {
  TemporaryFolder folder;
  WriteImage(folder / "a.png", Texture(160, 120, 3));
  WriteImage(folder / "flat.png", cv::Mat(64, 64, CV_8U, cv::Scalar(100)));
  FeatureOptions options;
  const FeatureCache cache(folder / "cache", options);
  RawFeatures read;
  CHECK(!cache.Read("a", folder / "a.png", &read));
  for (const std::string name : {"a", "flat"}) {
    const std::string path = folder / (name + ".png");
    const RawFeatures raw = ExtractRawFeatures(path, options);
    cache.Write(name, path, raw);
    REQUIRE(cache.Read(name, path, &read));
    CHECK((read.size == raw.size && read.positions == raw.positions && read.bytes == raw.bytes));
    CHECK(read.frames == raw.frames);
    CHECK((name == "flat") == (read.bytes.rows() == 0));
  }
  options.kind = FeatureKind::kSift;
  CHECK(FeatureCache(folder / "cache", options).Read("a", folder / "a.png", &read));
  options.max_keypoints = 10;
  CHECK(!FeatureCache(folder / "cache", options).Read("a", folder / "a.png", &read));
  CHECK(!cache.Read("a", folder / "flat.png", &read));
  const std::string file = folder / "cache/a.bin", content = ReadFile(file);
  for (std::size_t size : {std::size_t{0}, std::size_t{40}, content.size() / 2, content.size() - 1}) {
    WriteRaw(file, content.substr(0, size));
    CHECK(!cache.Read("a", folder / "a.png", &read));
  }
}

}  // namespace diffsac
