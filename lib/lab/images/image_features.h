#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "diffsac/core/enum_names.h"
#include "diffsac/geometry/points.h"
#include "diffsac/problem/image_pair.h"
#include "lab/files/correspondence_files.h"

namespace diffsac {

/// SIFT (Lowe, "Distinctive image features from scale-invariant keypoints", IJCV 2004); RootSIFT, the roots of its
/// L1-normalised values (Arandjelović and Zisserman, "Three things everyone should know to improve object retrieval",
/// CVPR 2012); ORB (Rublee et al., "ORB: an efficient alternative to SIFT or SURF", ICCV 2011); XFeat, which LibTorch
/// runs (lab/images/network_keypoints.h).
enum class FeatureKind { kSift, kRootSift, kOrb, kXFeat };
template <>
inline constexpr auto kEnumNames<FeatureKind> = NamesOf<FeatureKind>({{FeatureKind::kSift, "sift"},
                                                                      {FeatureKind::kRootSift, "rootsift"},
                                                                      {FeatureKind::kOrb, "orb"},
                                                                      {FeatureKind::kXFeat, "xfeat"}});
/// Whether its descriptors are SIFT's values.
inline bool IsSift(FeatureKind kind) { return kind == FeatureKind::kSift || kind == FeatureKind::kRootSift; }

struct FeatureOptions {
  FeatureKind kind = FeatureKind::kRootSift;
  int max_keypoints = 8000;  ///< The strongest are kept; 0 keeps all.
  /// Larger images are reduced to this longer side, in pixels; 0: never.
  int max_image_size = 0;
  void Check() const;  ///< Throws Error.
};
/// Of SIFT's detector; it stands in what names the files that are made of its keypoints.
inline constexpr double kContrastThreshold = 0.04;

/// N descriptors as the detector gives them, one a row: SIFT's 128 values, ORB's 32 bytes, the bytes of
/// XFeat's 64 numbers.
using ByteMatrix = Eigen::Matrix<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The keypoints of one image, strongest first.
struct RawFeatures {
  ImageSize size;         ///< Of the file's pixels, whatever its orientation flag says.
  PointMatrix positions;  ///< N × 2, pixels of the file, the centre of the first pixel is (0, 0).
  PointMatrix frames;     ///< N × 2: the logarithm of the diameter in pixels of the file; the angle in radians.
                          ///< XFeat's say nothing.
  ByteMatrix bytes;
};

/// The same with descriptors as they are matched and stored.
struct ImageFeatures {
  ImageSize size;
  PointMatrix positions;
  PointMatrix frames;            ///< As RawFeatures::frames; empty where keypoints have no size and angle.
  DescriptorMatrix descriptors;  ///< N × 128 (XFeat: 64) of unit length, or ORB's N × 256 bits, each 0 or 1.
};

/// An image without texture has no keypoints. Throws Error when the file is no image.
RawFeatures ExtractRawFeatures(const std::string& path, const FeatureOptions& options);
DescriptorMatrix DescriptorsFromBytes(const ByteMatrix& bytes, FeatureKind kind);
ImageFeatures FeaturesFromRaw(const RawFeatures& raw, FeatureKind kind);
ImageFeatures ExtractFeatures(const std::string& path, const FeatureOptions& options);

/// "640x480".
std::string SizeText(const ImageSize& size);
/// Width and height of an image file. Throws Error when it is none.
ImageSize ReadImageSize(const std::string& path);

/// Euclidean for rows of unit length, Hamming for rows of 0 and 1.
enum class DescriptorDistance { kEuclidean, kHamming };
DescriptorDistance DistanceOf(FeatureKind kind);

struct DescriptorMatch {
  int first = 0, second = 0;  ///< Rows.
  double ratio = 1.0;         ///< Distance of `first` to its nearest row over that to the next one, in [0, 1].
};

/// All pairs of rows that are each other's nearest, in the order of the first; nothing is thrown away by its ratio.
/// Equally near rows: the lower index.
std::vector<DescriptorMatch> MatchMutually(const DescriptorMatrix& first, const DescriptorMatrix& second,
                                           DescriptorDistance distance = DescriptorDistance::kEuclidean);

/// The ratio of given matches: the distance of a match over that to the nearest other row of `second`, at most 1. Rows
/// are of unit length.
Eigen::VectorXd SnnRatios(const DescriptorMatrix& first, const DescriptorMatrix& second, const MatchIndices& matches);

}  // namespace diffsac
