#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lab/files/correspondence_files.h"
#include "lab/images/image_features.h"

namespace diffsac {

/// Keypoints of one image in a features file of hloc's (Sarlin et al., "From coarse to fine", CVPR 2019).
struct HlocImage {
  std::string name;          ///< The image file, with folders before it where there are some.
  PointMatrix keypoints;     ///< N × 2, pixels of the image as it is stored, the centre of the first one is (0, 0).
  ImageSize size;            ///< Zero when the file has no image_size.
  PointMatrix frames;        ///< N × 2: logarithm of the size, angle in radians; empty when the file has none.
  std::string problem = {};  ///< Why nothing of it can be used, with file and group; empty: it can.
};

/// One pair of a matches file of hloc's.
struct HlocPair {
  std::string group;           ///< Its place in the file, for messages.
  std::size_t image1, image2;  ///< Of the images.
  MatchIndices matches;
  Eigen::VectorXd scores;  ///< One a match, in [0, 1], higher is better; empty when the file has none.
};

struct HlocFiles {
  std::vector<HlocImage> images;
  std::vector<HlocPair> pairs;  ///< In the order of their names; of two that match the same images, the first.
  int repeated = 0;             ///< Pairs that were left out because they repeat another.
  /// Pairs that were left out: what is wrong with those that are wrong themselves, and how many of images that are.
  std::vector<std::string> bad_pairs;
  int of_bad_images = 0;
};

/// Reads them. A group NAME of `features` holds `keypoints` (N × 2) and, optionally, `image_size` (width, height),
/// `scales` and `oris` (N each: SIFT's sizes, and angles in degrees). A group NAME1/NAME2 of `matches`, with '-' for
/// the '/' of folders in names, or in older files NAME1_NAME2, holds `matches0` (for each keypoint of image 1 that of
/// image 2, or -1) and, optionally, `matching_scores0`. Images and pairs whose values contradict each other, and pairs
/// whose names are no images or can be read in several ways, are left out. Throws Error with one line that names file
/// and group: no HDF5, no features or matches, nothing left.
HlocFiles ReadHlocFiles(const std::string& features, const std::string& matches);

/// Which kind of file it is.
enum class HlocKind { kFeatures, kMatches, kNeither };
HlocKind KindOfHlocFile(const std::string& path);

/// Keypoints and descriptors made elsewhere (SuperPoint, ...), in an HDF5 file as hloc writes it: a group for each
/// image, named by its file (with folders before it or not, with extension or not), that holds
///   keypoints    N × 2, pixels of the image as it is stored, the centre of the first pixel is (0, 0)
///   descriptors  D × N (as hloc does; taken for N = D too) or N × D
///   scores       N, optional: the strongest are kept where not all are
///   image_size   width, height, optional: must be those of the image
/// Descriptors are brought to unit length and matched by their Euclidean distance. Thread-safe.
class ImportedFeatures {
 public:
  /// Throws Error, like Read, with one line that names the file and the key.
  explicit ImportedFeatures(const std::string& path);
  ~ImportedFeatures();

  /// `image_path` has the size `size`. At most `max_keypoints` (0: all).
  ImageFeatures Read(const std::string& image_path, const ImageSize& size, int max_keypoints) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diffsac
