#include "lab/images/image_features.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "diffsac/core/status.h"
#include "lab/images/detection.h"

namespace diffsac {
namespace {

constexpr int kSiftSize = 128, kOrbBytes = 32, kXFeatSize = 64;

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

int BytesOf(FeatureKind kind) {
  if (kind == FeatureKind::kXFeat) return kXFeatSize * sizeof(float);
  return kind == FeatureKind::kOrb ? kOrbBytes : kSiftSize;
}

// Dividing the roots by their length is the L1 norm of what the roots were taken of.
Eigen::RowVectorXf UnitRow(const Eigen::RowVectorXf& values) {
  const float length = values.norm();
  return length > 0.0f ? Eigen::RowVectorXf(values / length)
                       : Eigen::RowVectorXf::Constant(kSiftSize, 1.0f / std::sqrt(float{kSiftSize}));
}

}  // namespace

DescriptorDistance DistanceOf(FeatureKind kind) {
  return kind == FeatureKind::kOrb ? DescriptorDistance::kHamming : DescriptorDistance::kEuclidean;
}

void FeatureOptions::Check() const {
  if (max_keypoints < 0) throw Error("max_keypoints must not be negative");
  if (max_image_size < 0) throw Error("max_image_size must not be negative");
}

RawFeatures ExtractRawFeatures(const std::string& path, const FeatureOptions& options) {
  options.Check();
  const Detection found = Detect(path, options);
  std::vector<int> order = Order(found.keypoints);
  // The detector keeps all that are as strong as the last one.
  if (options.max_keypoints > 0 && order.size() > static_cast<std::size_t>(options.max_keypoints))
    order.resize(options.max_keypoints);
  const auto count = static_cast<Eigen::Index>(order.size());
  RawFeatures features{found.size, PointMatrix(count, 2), PointMatrix(count, 2),
                       ByteMatrix(count, BytesOf(options.kind))};
  for (Eigen::Index i = 0; i < count; ++i) {
    features.positions.row(i) = found.Position(order[i]);
    features.frames.row(i) = found.Frame(order[i]);
    CopyBytes(found.raw, order[i], i, &features.bytes);
  }
  return features;
}

DescriptorMatrix DescriptorsFromBytes(const ByteMatrix& bytes, FeatureKind kind) {
  if (kind == FeatureKind::kOrb) {
    DescriptorMatrix bits(bytes.rows(), 8 * bytes.cols());
    for (Eigen::Index i = 0; i < bits.rows(); ++i)
      for (Eigen::Index j = 0; j < bits.cols(); ++j) bits(i, j) = static_cast<float>((bytes(i, j / 8) >> (j % 8)) & 1);
    return bits;
  }
  if (kind == FeatureKind::kXFeat)
    return Eigen::Map<const DescriptorMatrix>(reinterpret_cast<const float*>(bytes.data()), bytes.rows(), kXFeatSize);
  DescriptorMatrix rows(bytes.rows(), bytes.cols());
  for (Eigen::Index i = 0; i < bytes.rows(); ++i) {
    const Eigen::RowVectorXf values = bytes.row(i).cast<float>();
    rows.row(i) = UnitRow(kind == FeatureKind::kRootSift ? Eigen::RowVectorXf(values.cwiseSqrt()) : values);
  }
  return rows;
}

ImageFeatures FeaturesFromRaw(const RawFeatures& raw, FeatureKind kind) {
  return {raw.size, raw.positions, kind == FeatureKind::kXFeat ? PointMatrix() : raw.frames,
          DescriptorsFromBytes(raw.bytes, kind)};
}

ImageFeatures ExtractFeatures(const std::string& path, const FeatureOptions& options) {
  return FeaturesFromRaw(ExtractRawFeatures(path, options), options.kind);
}

std::string SizeText(const ImageSize& size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

ImageSize ReadImageSize(const std::string& path) {
  const cv::Mat image = ReadGrayImage(path);
  return {image.cols, image.rows};
}

}  // namespace diffsac
