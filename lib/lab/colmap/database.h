#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "diffsac/geometry/points.h"
#include "diffsac/problem/image_pair.h"
#include "lab/colmap/sqlite.h"
#include "lab/files/correspondence_files.h"

namespace diffsac {

/// A row of `cameras`.
struct ColmapCamera {
  int model = 0;  ///< Number of the camera model (lab/colmap/lens.h).
  ImageSize size;
  std::vector<double> parameters;
  bool has_prior_focal_length = false;  ///< From EXIF or given by the user; else COLMAP's guess, 1.2 × the longer side.
};

/// A row of `images`.
struct ColmapImage {
  std::string name;  ///< File, with folders before it where there are some.
  std::int64_t camera = 0;
};

/// Two images by their ids, the smaller one first: the order of COLMAP's rows.
struct ColmapPair {
  std::int64_t image1 = 0, image2 = 0;
  auto operator<=>(const ColmapPair&) const = default;
};

/// Bytes of a keypoint's descriptor; N × 128 for SIFT.
using ColmapDescriptors = Eigen::Matrix<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A database of COLMAP (https://colmap.github.io/database.html): cameras, images, keypoints and matches, whoever made
/// them; to read from 2016's on, to write 3.8 or later. Images without a camera and pairs without their images are left
/// out, with a warning. All here throw Error with one line that starts with the file's path: what SqliteDatabase says,
/// another schema, no images, values that contradict each other.
class ColmapDatabase {
 public:
  /// Reads cameras and images.
  explicit ColmapDatabase(const std::string& path, SqliteDatabase::Access access = SqliteDatabase::Access::kRead);

  const std::string& path() const { return sqlite_.path(); }
  const SqliteDatabase& sqlite() const { return sqlite_; }
  /// By their ids.
  const std::map<std::int64_t, ColmapImage>& images() const { return images_; }
  /// Of an image.
  const ColmapCamera& CameraOf(std::int64_t image) const { return cameras_.at(images_.at(image).camera); }
  /// "image 'a.jpg'", for messages.
  std::string NameOf(std::int64_t image) const { return "image '" + images_.at(image).name + "'"; }

  /// N × 2 x y in COLMAP's pixels: the centre of the first one is (0.5, 0.5).
  PointMatrix Keypoints(std::int64_t image) const;
  /// N × 2: the logarithm of the scale, and the orientation in radians from the x axis towards the y axis. None where
  /// keypoints have none (two columns), one that is no scale, or all the same: such were made up.
  PointMatrix KeypointFrames(std::int64_t image) const;
  /// As many rows as keypoints, or none where there are no descriptors.
  ColmapDescriptors Descriptors(std::int64_t image) const;
  /// How many keypoints there are; 0 where the image has none.
  std::int64_t KeypointCount(std::int64_t image) const;

  /// Pairs that have matches, or `verified` ones (two_view_geometries), in ascending order.
  std::vector<ColmapPair> MatchedPairs(bool verified = false) const;
  /// Rows of the keypoints of image 1 and 2 for each match; none for a pair that was not matched.
  MatchIndices Matches(const ColmapPair& pair, bool verified = false) const;

 private:
  using StoredKeypoints = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  StoredKeypoints ReadKeypoints(std::int64_t image) const;
  void CheckSchema(bool writes);
  void ReadCameras();
  void ReadImages();

  SqliteDatabase sqlite_;
  std::map<std::int64_t, ColmapCamera> cameras_;
  std::map<std::int64_t, ColmapImage> images_;
  bool has_prior_ = true;  // Without it no focal length is a prior one.
};

/// COLMAP's number of a pair.
std::int64_t PairId(const ColmapPair& pair);
/// Which images a number means.
ColmapPair PairOfId(std::int64_t pair_id);

/// A name for each image that can stand in "img1-img2" (lab/files/correspondence_files.h): the file without extension,
/// with
/// '_' for '-' and for the '/' of folders. Where several images would have the same one, their ids follow it. Throws
/// Error where they still do.
std::map<std::int64_t, std::string> PairNames(const std::map<std::int64_t, std::string>& files);
std::map<std::int64_t, std::string> PairNames(const ColmapDatabase& database);

/// An image of a new database.
struct NewColmapImage {
  std::string name;        ///< File, with the folders before it.
  std::size_t camera = 0;  ///< Index of NewColmapDatabase::cameras.
  PointMatrix keypoints;   ///< N × 2, COLMAP's pixels: the centre of the first one is (0.5, 0.5).
  PointMatrix frames;      ///< N × 2: the logarithm of the scale, the orientation in radians.
};

/// What a new database holds. The id of an image is its index plus one.
struct NewColmapDatabase {
  std::vector<ColmapCamera> cameras;
  std::vector<NewColmapImage> images;
  std::map<ColmapPair, MatchIndices> matches;  ///< By the images' ids, the smaller one first.
};

/// Writes a database of COLMAP 3.8's schema (https://colmap.github.io/database.html) without descriptors and two-view
/// geometries (WriteGeometries adds these), whole or not at all, in place of an older file. Throws Error.
void CreateColmapDatabase(const std::string& path, const NewColmapDatabase& content);

}  // namespace diffsac
