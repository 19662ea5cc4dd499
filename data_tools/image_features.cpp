#include "data_tools/image_features.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

constexpr int kDescriptorSize = 128;
constexpr Eigen::Index kBlockRows = 256;

// Calibrations refer to the pixels as stored, so the orientation flag is ignored.
cv::Mat ReadGrayImage(const std::string& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) throw Error(path + ": no such file");
  cv::Mat image;
  try {
    image = cv::imread(path, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& e) {
    throw Error(path + ": cannot be read as an image: " + e.err);
  }
  if (image.empty()) throw Error(path + ": not an image, or truncated");
  return image;
}

// Returns original pixels per reduced pixel.
double Reduce(int max_size, cv::Mat* image) {
  const int longer = std::max(image->cols, image->rows);
  if (max_size == 0 || longer <= max_size) return 1.0;
  const double scale = static_cast<double>(longer) / max_size;
  cv::Mat reduced;
  cv::resize(*image, reduced,
             cv::Size(std::max(1, static_cast<int>(std::lround(image->cols / scale))),
                      std::max(1, static_cast<int>(std::lround(image->rows / scale)))),
             0, 0, cv::INTER_AREA);
  *image = reduced;
  return scale;
}

// Strongest first; the rest makes the order complete.
std::vector<int> Order(const std::vector<cv::KeyPoint>& keypoints) {
  std::vector<int> order(keypoints.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const auto key = [&](int i) {
      const cv::KeyPoint& k = keypoints[i];
      return std::make_tuple(-k.response, k.pt.y, k.pt.x, k.size, k.angle, i);
    };
    return key(a) < key(b);
  });
  return order;
}

Eigen::RowVectorXf RootOfNormalised(const float* values) {
  const Eigen::RowVectorXf raw = Eigen::Map<const Eigen::RowVectorXf>(values, kDescriptorSize).cwiseMax(0.0f);
  const Eigen::RowVectorXf root = raw.cwiseSqrt();
  const float length = root.norm();
  // Dividing by the length is the L1 norm of what the root was taken of.
  return length > 0.0f ? Eigen::RowVectorXf(root / length)
                       : Eigen::RowVectorXf::Constant(kDescriptorSize, 1.0f / std::sqrt(float{kDescriptorSize}));
}

double SquaredDistance(const DescriptorMatrix& first, int i, const DescriptorMatrix& second, int j) {
  return (first.row(i).cast<double>() - second.row(j).cast<double>()).squaredNorm();
}

// The two most similar rows of the other matrix.
struct TwoNearest {
  float best = -std::numeric_limits<float>::infinity(), next = best;
  int best_index = -1, next_index = -1;

  void See(float similarity, int index) {
    if (similarity > best) {
      next = best;
      next_index = best_index;
      best = similarity;
      best_index = index;
    } else if (similarity > next) {
      next = similarity;
      next_index = index;
    }
  }
};

struct Nearest {
  std::vector<TwoNearest> of_first;
  std::vector<int> of_second;
};

// Between rows of unit length the nearest has the largest inner product, which a matrix product gives fast.
Nearest FindNearest(const DescriptorMatrix& first, const DescriptorMatrix& second) {
  Nearest nearest{std::vector<TwoNearest>(first.rows()), std::vector<int>(second.rows(), -1)};
  std::vector<float> best_of_second(second.rows(), -std::numeric_limits<float>::infinity());
  DescriptorMatrix similarity;
  for (Eigen::Index start = 0; start < first.rows(); start += kBlockRows) {
    const Eigen::Index rows = std::min(kBlockRows, first.rows() - start);
    similarity.noalias() = first.middleRows(start, rows) * second.transpose();
    for (Eigen::Index r = 0; r < rows; ++r) {
      const auto i = static_cast<int>(start + r);
      const float* row = similarity.row(r).data();
      for (int j = 0; j < static_cast<int>(second.rows()); ++j) {
        nearest.of_first[i].See(row[j], j);
        if (row[j] > best_of_second[j]) {
          best_of_second[j] = row[j];
          nearest.of_second[j] = i;
        }
      }
    }
  }
  return nearest;
}

double Ratio(const DescriptorMatrix& first, int i, const DescriptorMatrix& second, const TwoNearest& nearest) {
  if (nearest.next_index < 0) return 1.0;
  const double best = SquaredDistance(first, i, second, nearest.best_index);
  const double next = SquaredDistance(first, i, second, nearest.next_index);
  return next > 0.0 ? std::min(1.0, std::sqrt(best / next)) : 1.0;
}

}  // namespace

void FeatureOptions::Check() const {
  if (max_keypoints < 0) throw Error("max_keypoints must not be negative");
  if (!(contrast_threshold >= 0.0)) throw Error("contrast_threshold must not be negative");
  if (max_image_size < 0) throw Error("max_image_size must not be negative");
}

ImageFeatures ExtractRootSift(const std::string& path, const FeatureOptions& options) {
  options.Check();
  cv::Mat image = ReadGrayImage(path);
  ImageFeatures features;
  features.size = {image.cols, image.rows};
  const double scale = Reduce(options.max_image_size, &image);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat raw;
  try {
    cv::SIFT::create(options.max_keypoints, 3, options.contrast_threshold)
        ->detectAndCompute(image, cv::noArray(), keypoints, raw);
  } catch (const cv::Exception& e) {
    throw Error(path + ": no keypoints could be found: " + e.err);
  }
  std::vector<int> order = Order(keypoints);
  // The detector keeps all that are as strong as the last one.
  if (options.max_keypoints > 0 && order.size() > static_cast<std::size_t>(options.max_keypoints))
    order.resize(options.max_keypoints);
  features.positions.resize(static_cast<Eigen::Index>(order.size()), 2);
  features.descriptors.resize(static_cast<Eigen::Index>(order.size()), kDescriptorSize);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const cv::Point2f position = keypoints[order[i]].pt;
    const auto row = static_cast<Eigen::Index>(i);
    features.positions.row(row) << (position.x + 0.5) * scale - 0.5, (position.y + 0.5) * scale - 0.5;
    features.descriptors.row(row) = RootOfNormalised(raw.ptr<float>(order[i]));
  }
  return features;
}

ImageSize ReadImageSize(const std::string& path) {
  const cv::Mat image = ReadGrayImage(path);
  return {image.cols, image.rows};
}

std::vector<DescriptorMatch> MatchMutually(const DescriptorMatrix& first, const DescriptorMatrix& second) {
  std::vector<DescriptorMatch> matches;
  if (first.rows() == 0 || second.rows() == 0) return matches;
  const Nearest nearest = FindNearest(first, second);
  for (int i = 0; i < static_cast<int>(first.rows()); ++i) {
    const TwoNearest& of_first = nearest.of_first[i];
    if (of_first.best_index < 0 || nearest.of_second[of_first.best_index] != i) continue;
    matches.push_back({i, of_first.best_index, Ratio(first, i, second, of_first)});
  }
  return matches;
}

}  // namespace diffsac
