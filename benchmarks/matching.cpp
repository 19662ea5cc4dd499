// Descriptors of two images matched: what MatchMutually takes, beside a product by Eigen and OpenCV's matcher.
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <iostream>
#include <opencv2/core/utility.hpp>
#include <opencv2/features2d.hpp>

#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "lab/images/image_features.h"
#include "measure.h"

namespace {

using namespace diffsac;
using Pairs = std::vector<std::pair<int, int>>;

// Unit rows; the second image's are the first's with noise, in another order.
void Draw(int count, DescriptorMatrix* first, DescriptorMatrix* second) {
  Rng rng(1);
  first->resize(count, 128);
  second->resize(count, 128);
  for (Eigen::Index i = 0; i < first->size(); ++i) first->data()[i] = static_cast<float>(std::abs(rng.Normal()));
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < 128; ++j)
      (*second)(count - 1 - i, j) = (*first)(i, j) + static_cast<float>(0.8 * std::abs(rng.Normal()));
  first->rowwise().normalize();
  second->rowwise().normalize();
}

// Blocks of rows by Eigen's product, compiled for plain x86-64, and the largest of each row and column.
Pairs ByEigen(const DescriptorMatrix& first, const DescriptorMatrix& second) {
  constexpr Eigen::Index kRows = 256;
  std::vector<int> of_first(first.rows()), of_second(second.rows(), -1);
  std::vector<float> best(second.rows(), -2.0f);
  DescriptorMatrix similarity;
  for (Eigen::Index start = 0; start < first.rows(); start += kRows) {
    const Eigen::Index rows = std::min(kRows, first.rows() - start);
    similarity.noalias() = first.middleRows(start, rows) * second.transpose();
    for (Eigen::Index r = 0; r < rows; ++r) {
      float largest = -2.0f, next = -2.0f;
      for (Eigen::Index j = 0; j < second.rows(); ++j) {
        const float value = similarity(r, j);
        if (value > largest) {
          next = largest;
          largest = value;
          of_first[start + r] = static_cast<int>(j);
        } else if (value > next) {
          next = value;
        }
        if (value > best[j]) {
          best[j] = value;
          of_second[j] = static_cast<int>(start + r);
        }
      }
    }
  }
  Pairs pairs;
  for (int i = 0; i < static_cast<int>(first.rows()); ++i)
    if (of_second[of_first[i]] == i) pairs.emplace_back(i, of_first[i]);
  return pairs;
}

Pairs ByOpenCv(const DescriptorMatrix& first, const DescriptorMatrix& second) {
  const auto view = [](const DescriptorMatrix& rows) {
    return cv::Mat(static_cast<int>(rows.rows()), static_cast<int>(rows.cols()), CV_32F,
                   const_cast<float*>(rows.data()));
  };
  std::vector<cv::DMatch> matches;
  cv::BFMatcher(cv::NORM_L2, true).match(view(first), view(second), matches);
  Pairs pairs;
  for (const cv::DMatch& match : matches) pairs.emplace_back(match.queryIdx, match.trainIdx);
  return pairs;
}

Pairs ByUs(const DescriptorMatrix& first, const DescriptorMatrix& second) {
  Pairs pairs;
  for (const DescriptorMatch& match : MatchMutually(first, second)) pairs.emplace_back(match.first, match.second);
  return pairs;
}

int CountOfOthers(Pairs a, Pairs b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  Pairs others;
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(others));
  return static_cast<int>(others.size());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Milliseconds of matching two images' descriptors, one thread"};
  int keypoints = 8000, rounds = 5;
  std::vector<std::string> images;
  app.add_option("images", images, "Two images (default: descriptors drawn at random)")->expected(2);
  app.add_option("--keypoints", keypoints, "Of an image")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--rounds", rounds, "Each way is run so often, in turn")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  try {
    cv::setNumThreads(1);
    DescriptorMatrix first, second;
    if (images.empty()) {
      Draw(keypoints, &first, &second);
    } else {
      FeatureOptions options;
      options.max_keypoints = keypoints;
      first = ExtractFeatures(images[0], options).descriptors;
      second = ExtractFeatures(images[1], options).descriptors;
    }
    using Way = Pairs (*)(const DescriptorMatrix&, const DescriptorMatrix&);
    const std::pair<const char*, Way> ways[] = {{"MatchMutually", ByUs}, {"Eigen", ByEigen}, {"OpenCV", ByOpenCv}};
    std::vector<std::vector<double>> ms(std::size(ways));
    std::vector<Pairs> found(std::size(ways));
    for (int round = 0; round < rounds; ++round)
      for (std::size_t w = 0; w < std::size(ways); ++w)
        ms[w].push_back(Milliseconds([&] { found[w] = ways[w].second(first, second); }));
    for (std::vector<double>& times : ms) std::sort(times.begin(), times.end());
    for (std::size_t w = 0; w < std::size(ways); ++w)
      std::printf("%-14s %8.1f ms  %5.2f x  %zu matches, %d others than MatchMutually's\n", ways[w].first,
                  ms[w][ms[w].size() / 2], ms[w][ms[w].size() / 2] / ms[0][ms[0].size() / 2], found[w].size(),
                  CountOfOthers(found[w], found[0]));
  } catch (const std::exception& error) {
    std::cerr << "diffsac_matching: " << MessageOf(error) << std::endl;
    return 2;
  }
}
