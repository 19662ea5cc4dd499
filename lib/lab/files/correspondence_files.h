#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lab/ground_truth/example.h"

namespace diffsac {

/// Rows of two lists of keypoints, image 1's and image 2's, for each match.
using MatchIndices = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// How a scene in the layout of the CVPR 2020 RANSAC tutorial is read.
struct CorrespondenceOptions {
  bool descriptors = false;  ///< Whether to read `descriptors.h5` where it exists.
};

/// One scene in the layout of the CVPR 2020 RANSAC tutorial: a folder of flat HDF5 files whose data sets carry the name
/// of a pair, "img1-img2" (or, in R.h5 and T.h5, of an image). Numbers of any type are accepted.
///
///   matches.h5       N × 4: x1 y1 x2 y2, pixels                              required
///   match_conf.h5    N values, second-nearest-neighbour ratio                optional, like all below
///   similarities.h5  N × 2: log(size2 / size1) and angle2 − angle1, radians, of the keypoints
///   (Problem::scale_rotation_changes) K1_K2.h5         1 × 2 × 3 × 3: K1, then K2 R.h5, T.h5       3 × 3 and 3 values
///   an image, world-to-camera            both or none Egt.h5, Fgt.h5   3 × 3: x2ᵀ F x1 = 0, E in coordinates K⁻¹ x
///   Hgt.h5           3 × 3: x2 ~ H x1
///   sizes.h5         h1 w1 h2 w2
///   descriptors.h5   N × 2d: image 1, then image 2
///   labels.h5        N integers: 0 an outlier, k ≥ 1 an inlier of structure k
///   match_indices.h5 N × 2 integers: which keypoints of image 1 and 2, counted from 0 in the lists that the matches
///                    came from; for those who go back there, and read by ReadMatchIndices alone
///   thumbnails.h5    an image: the bytes of a small JPEG for pictures (lab/images/pictures.h); not read here
///
/// A file that is there must hold every pair. E and F that are not stored are derived from what is (CompleteTruth).
/// A pair's id may have another form than "img1-img2" where no R.h5 asks for images (the tutorial's homographies).
/// Files open when they are first needed and stay open. Thread-safe: one lock guards the HDF5 library.
class CorrespondenceScene {
 public:
  /// Reads the names of the pairs alone. Throws Error, like all here, with one line that names the file, and the data
  /// set where there is one.
  explicit CorrespondenceScene(const std::string& folder, const CorrespondenceOptions& options = {});
  ~CorrespondenceScene();
  CorrespondenceScene(CorrespondenceScene&&) noexcept;
  CorrespondenceScene& operator=(CorrespondenceScene&&) noexcept;

  const std::string& folder() const;
  /// The name of the folder.
  const std::string& scene() const;
  /// In the order of the names.
  const std::vector<std::string>& pairs() const;
  std::int64_t size() const { return static_cast<std::int64_t>(pairs().size()); }

  /// Reads one pair: `id` is its name, `truth` what the files know, and `problem` as yet of no task: fundamental
  /// matrices, ε = 1 px, without model, pose and inliers (SetTask in lab/ground_truth/pair_truth.h). Throws Error for
  /// an index out of range as well.
  Example Read(std::int64_t index) const;
  /// The rows of match_indices.h5 for a pair of `num_matches`. Throws Error where there is no such file as well.
  MatchIndices ReadMatchIndices(const std::string& id, Eigen::Index num_matches) const;
  /// Closes the files until the next pair is read.
  void CloseFiles() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What a scene's folder holds.
struct CorrespondenceSet {
  std::vector<Example> pairs;
  /// World-to-camera, for R.h5 and T.h5, by image. `truth.motion` of the pairs is not stored: reading derives it.
  std::map<std::string, RigidMotion> cameras;
  /// The N × 2d descriptors of a pair, asked for one after the other so that all need not be in memory at once.
  /// Not set: `problem.descriptors` of the pairs.
  std::function<DescriptorMatrix(std::size_t)> descriptors;
  /// The keypoints behind the matches, of each pair; empty: not known.
  std::vector<MatchIndices> match_indices;
};

/// Writes a folder that CorrespondenceScene reads back without loss. A file is written when all pairs have what it
/// holds, and is an Error when only some have. `matches.h5` of an earlier set goes first and comes last, each file
/// appears whole: a folder that was interrupted reads as incomplete, never as something else. Throws Error when it
/// cannot be written, for an empty set, and for ids that are equal or no names of data sets.
void WriteCorrespondences(const std::string& folder, const CorrespondenceSet& set);

}  // namespace diffsac
