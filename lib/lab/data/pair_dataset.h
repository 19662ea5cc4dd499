#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/problem/tasks.h"
#include "lab/data/pair_filter.h"
#include "lab/data/pair_scenes.h"
#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// What becomes of a pair without matches: an error that names file and key, or a problem without points, which every
/// estimator reports as too few.
enum class EmptyPairs { kError, kKeep };
template <>
inline constexpr auto kEnumNames<EmptyPairs> = NamesOf<EmptyPairs>({{EmptyPairs::kError, "error"},
                                                                    {EmptyPairs::kKeep, "keep"}});

/// What all datasets of correspondence files (lab/files/correspondence_files.h) have in common: as which problem their
/// pairs are read, and which pairs and matches are taken. Datasets that differ by a filter read each pair once between
/// them (lab/data/pair_reading.h).
struct PairsOptions {
  Task task = Task::kFundamental;    ///< Of two views.
  double inlier_threshold_px = 1.0;  ///< ε, linear.

  PairFilter filter;  ///< Its keys stand beside the others.

  /// Only pairs with at least so many matches left; more than 0 reads them all when the dataset is made.
  int min_points = 0;
  /// The part of each scene's pairs, in the order of their names, that is used: [0, 1] all, [0.8, 1] the last fifth.
  /// The same scene can train and validate.
  Range part = {0.0, 1.0};
  /// At most so many pairs of that part of a scene, evenly spread; 0 keeps all.
  int max_pairs = 0;
  /// For training: inliers and models come from the truth refined on the matches near it (lab/data/fitted_truth.h),
  /// truncated at so many pixels; 0 takes the source's truth.
  double refine_truth_px = 0.0;
  /// Task homography, pairs that have a pose but no homography: the truth is that of most true matches
  /// (lab/data/fitted_truth.h); where there is none, the example has no true model and no inliers.
  bool dominant_plane = false;
  /// Task homography or fundamental, pairs with labels (labels.h5): several models are true at once, that of each label
  /// (FitInstances in lab/data/fitted_truth.h; its loss is inlier_threshold_px), and the labels are renumbered from
  /// the largest to the smallest of the matches that the filter leaves. Labels of fewer than FewestLabelled
  /// become outliers.
  bool instances = false;
  /// Pairs of all scenes in one random order (decided by the seed of the run), for training; else scene by scene.
  bool shuffle = false;
  EmptyPairs empty_pairs = EmptyPairs::kError;
  bool descriptors = false;  ///< Whether descriptors.h5 is read where it is there.

  /// `ratio_key`: the name of filter.max_ratio.
  void Bind(OptionsBinder& b, const char* ratio_key);
};

/// What a dataset holds of its pairs.
enum class PairMemory {
  kAll,     ///< All of them, read when it is made.
  kRecent,  ///< Only their names, listed once; a pair is read when it is asked for, and the last ones are kept
            ///< (PairReading). A file is opened when it is first needed and stays open.
};

/// The pairs of these scenes. Throws Error naming the file: a listing that fails, no pairs that have enough matches. A
/// pair that cannot be read, has no matches (empty_pairs), or no calibration where essential matrices are asked for, is
/// an Error naming file and key when it is read. Some pairs of each scene are looked at here, and what cannot teach or
/// measure is told of (PairCheck).
std::unique_ptr<Dataset> MakePairDataset(const std::vector<SceneFolder>& scenes, const PairsOptions& options,
                                         PairMemory memory, std::uint64_t seed);

/// Scenes anywhere; all pairs are read when the dataset is made and stay in memory.
struct CorrespondencesOptions {
  std::vector<std::string> paths;  ///< Folders of correspondence files, or folders of such folders; a scene each.
  PairsOptions pairs;              ///< Its keys stand beside the others; the ratio's is `max_ratio`.
  CorrespondencesOptions() { pairs.empty_pairs = EmptyPairs::kKeep; }
  void Bind(OptionsBinder& b);
};

/// As MakePairDataset.
std::unique_ptr<Dataset> MakeCorrespondences(const CorrespondencesOptions& options, std::uint64_t seed);

/// KITTI odometry as `diffsac_prepare pairs --format kitti` writes it: scenes kitti_<sequence>_step_<step> below root,
/// in the order of their names.
struct KittiOptions {
  std::string root;
  std::vector<std::string> sequences = {"00", "01", "02", "03", "04", "05", "06", "07"};  ///< Empty: all.
  std::vector<int> steps;                                                                 ///< Empty: all.
  PairsOptions pairs;  ///< Its keys stand beside the others; the ratio's is `snn_threshold`.
  void Bind(OptionsBinder& b);
};

/// As MakePairDataset.
std::unique_ptr<Dataset> MakeKitti(const KittiOptions& options, std::uint64_t seed);

/// The CVPR 2020 RANSAC tutorial: <root>/<split>/<scene>, or, for its homographies, <root>/<scene>/<split> with root
/// homography/, or <root>/<split> with root homography/EVD.
struct RansacTutorialOptions {
  std::string root;
  std::string split = "val";        ///< Folder name: "train", "val", "test"; "validation" means "val".
  std::vector<std::string> scenes;  ///< Empty: all, in the order of their names; else these, in their order.
  PairsOptions pairs;               ///< Its keys stand beside the others; the ratio's is `snn_threshold`.
  void Bind(OptionsBinder& b);
};

/// As MakePairDataset.
std::unique_ptr<Dataset> MakeRansacTutorial(const RansacTutorialOptions& options, std::uint64_t seed);

}  // namespace diffsac
