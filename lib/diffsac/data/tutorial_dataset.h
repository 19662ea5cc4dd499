#pragma once

#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/options.h"
#include "diffsac/data/problem.h"
#include "diffsac/data/two_view_dataset.h"

namespace diffsac {

/// How pairs are taken from correspondence files that are read one pair at a time, when it is asked for. Only the names
/// of the pairs are held in memory, and listed once; a file is opened when it is first needed and stays open.
struct PairStreamOptions {
  std::string task = "fundamental";  ///< "homography" | "fundamental" | "essential"
  double inlier_threshold_px = 1.0;  ///< ε, linear.
  /// Only matches whose ratio (match_conf.h5) is at most this; 1 keeps all, and so does data without ratios.
  double snn_threshold = 1.0;
  int max_points = 0;           ///< At most so many matches a pair; 0 keeps all.
  std::string cap = "best";     ///< Which: "best" by ratio (the first without ratios) | "random"
  bool shuffle_points = false;  ///< Matches in random order, the same whenever the pair is read.
  double refine_truth_px = 0.0;  ///< As of CorrespondencesOptions.
  bool dominant_plane = false;   ///< As of CorrespondencesOptions.
  int max_pairs = 0;            ///< At most so many pairs of a scene, evenly spread; 0 keeps all.
  /// Pairs of all scenes in one random order (decided by the seed of the run), for training; else scene by scene.
  bool shuffle = false;
  /// A pair without matches: "error" names file and key | "keep" gives a problem without points, which every estimator
  /// reports as too few.
  std::string empty_pairs = "error";
  bool descriptors = false;  ///< Whether descriptors.h5 is read where it is there.
  double descriptor_noise = 0.0;  ///< As of CorrespondencesOptions.
  void Bind(OptionsBinder& b);
};

/// The CVPR 2020 RANSAC tutorial: <root>/<split>/<scene>/matches.h5 and so on (data/correspondence_files.h), or, for
/// its homographies, <root>/<scene>/<split>/ with root homography/, or <root>/<split>/ with root homography/EVD.
struct RansacTutorialOptions {
  std::string root;
  std::string split = "val";        ///< Folder name: "train", "val", "test"; "validation" means "val".
  std::vector<std::string> scenes;  ///< Empty: all, in the order of their names.
  PairStreamOptions pairs;          ///< Its keys stand beside the others.
  void Bind(OptionsBinder& b);
};

/// KITTI odometry as `diffsac_prepare pairs --format kitti` writes it: scenes kitti_<sequence>_step_<step> below root.
struct KittiOptions {
  std::string root;
  std::vector<std::string> sequences = {"00", "01", "02", "03", "04", "05", "06", "07"};
  std::vector<int> steps;   ///< Empty: all.
  PairStreamOptions pairs;  ///< Its keys stand beside the others.
  void Bind(OptionsBinder& b);
};

/// Throw Error: a folder or scene that is not there, a listing that fails. `Get` throws Error naming file and key.
std::unique_ptr<Dataset> MakeRansacTutorial(const RansacTutorialOptions& options, std::uint64_t seed);
std::unique_ptr<Dataset> MakeKitti(const KittiOptions& options, std::uint64_t seed);

}  // namespace diffsac
