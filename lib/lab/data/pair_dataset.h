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
  Task task = Task::kFundamental;
  double inlier_threshold_px = 1.0;

  PairFilter filter;  ///< Its keys stand beside the others.

  int min_points = 0;
  Range part = {0.0, 1.0};
  int max_pairs = 0;
  double refine_truth_px = 0.0;
  bool dominant_plane = false;
  bool instances = false;
  bool shuffle = false;
  EmptyPairs empty_pairs = EmptyPairs::kError;
  bool descriptors = false;

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
  std::vector<std::string> paths;
  PairsOptions pairs;  ///< Its keys stand beside the others; the ratio's is `max_ratio`.
  CorrespondencesOptions() { pairs.empty_pairs = EmptyPairs::kKeep; }
  void Bind(OptionsBinder& b);
};

/// As MakePairDataset.
std::unique_ptr<Dataset> MakeCorrespondences(const CorrespondencesOptions& options, std::uint64_t seed);

/// KITTI odometry as `diffsac_prepare pairs --format kitti` writes it: scenes kitti_<sequence>_step_<step> below root,
/// in the order of their names.
struct KittiOptions {
  std::string root;
  std::vector<std::string> sequences = {"00", "01", "02", "03", "04", "05", "06", "07"};
  std::vector<int> steps;
  PairsOptions pairs;  ///< Its keys stand beside the others; the ratio's is `snn_threshold`.
  void Bind(OptionsBinder& b);
};

/// As MakePairDataset.
std::unique_ptr<Dataset> MakeKitti(const KittiOptions& options, std::uint64_t seed);

/// The CVPR 2020 RANSAC tutorial: <root>/<split>/<scene>, or, for its homographies, <root>/<scene>/<split> with root
/// homography/, or <root>/<split> with root homography/EVD.
struct RansacTutorialOptions {
  std::string root;
  std::string split = "val";
  std::vector<std::string> scenes;
  PairsOptions pairs;  ///< Its keys stand beside the others; the ratio's is `snn_threshold`.
  void Bind(OptionsBinder& b);
};

/// As MakePairDataset.
std::unique_ptr<Dataset> MakeRansacTutorial(const RansacTutorialOptions& options, std::uint64_t seed);

}  // namespace diffsac
