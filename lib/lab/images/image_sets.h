#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "lab/images/run_pairs.h"
#include "lab/options/options.h"

namespace diffsac {

/// A set of images that tables or trainings are about, and how its matches are made: an entry of configs/sets.yaml.
struct ImageSet {
  std::string name;
  std::vector<std::string> input;  ///< Folders below the folder of data: the first that is there.
  std::string needs;               ///< A folder in the input that must be there; empty: the input itself.
  /// A format of data_tools/convert.py that the input comes in: what it makes, a COLMAP model below runs/converted, is
  /// the input instead. Without a `format` its scenes are the set.
  std::string convert;
  std::string output;               ///< Holds the scenes' folders; empty: only those with descriptors are made.
  std::vector<std::string> scenes;  ///< Which scenes it makes; `*` stands for any text.
  /// "test" or "train": the scenes are also made with descriptors, of each kind, in runs/descriptors/KIND/<this>.
  std::string described;
  /// Above 0: the images (at most so many) are first seen as planes from other places (WarpImages), `views` of each;
  /// a scene for each image, its name behind `pairs.scene`.
  int warp_images = 0, warp_views = 5;
  bool warp_photograph = false;                 ///< WarpRequest::photograph.
  std::vector<double> warp_tilt = {0.0, 65.0};  ///< Degrees: the least and the greatest.
  /// Its options' `import_descriptors` is a file below the folder of data.
  PairsRequest pairs;  ///< Without folders, which are found.
  void Bind(OptionsBinder& b);
};

/// The command `diffsac_prepare sets`.
struct SetsRequest {
  std::string config;  ///< A list of sets, `sets`.
  std::string data;    ///< The folder of data.
  std::vector<std::string>
      only;  ///< Sets by name (`*` stands for any text), or by a folder that they make; empty: all.
  int threads = 0;
};

/// The sets of a file, those with descriptors as sets of their own. Throws Error (file, line, nearest key).
std::vector<ImageSet> ReadImageSets(const std::string& path);

/// Whether a set goes by this name, or makes this folder, a folder in it or a folder around it.
bool Makes(const ImageSet& set, const std::string& name_or_folder);

/// Makes the matches of the wanted sets that are there, and says which are not. Scenes that are complete stay. False:
/// interrupted. Throws Error: no set is wanted, a set cannot be read.
bool PrepareSets(const SetsRequest& request, const std::atomic<bool>& stop);

}  // namespace diffsac
