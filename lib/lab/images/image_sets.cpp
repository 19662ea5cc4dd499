#include "lab/images/image_sets.h"

#include <fnmatch.h>

#include <algorithm>
#include <filesystem>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/eval/report_script.h"
#include "lab/images/run_pairs.h"
#include "lab/images/warp_images.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDescribedFeatures[] = {"rootsift", "orb"};

struct ImageSetList {
  std::vector<ImageSet> sets;
  void Bind(OptionsBinder& b) {
    b.Field("sets", sets).Help("image sets");
    b.Require(!sets.empty(), "sets", "a list of image sets");
  }
};

bool Matches(const std::string& pattern, const std::string& text) {
  return ::fnmatch(pattern.c_str(), text.c_str(), 0) == 0;
}

bool IsAround(const std::string& outer, const std::string& inner) { return inner.starts_with(outer + "/"); }

/// What a set reads below the folder of data.
struct SetFiles {
  std::string input, descriptors;  ///< The folder or file of its images; the file that it imports, empty: none.
  std::string missing;             ///< What of them is not there; empty: nothing.
};

bool IsThere(const fs::path& input, const std::string& needs) {
  return needs.empty() ? fs::exists(input) : fs::is_directory(input / needs);
}

SetFiles FilesOf(const ImageSet& set, const std::string& data) {
  const auto below = [&](const fs::path& path) { return (fs::path(data) / path).lexically_normal().string(); };
  SetFiles files;
  for (const std::string& input : set.input)
    if (files.input.empty() && IsThere(fs::path(data) / input, set.needs)) files.input = below(input);
  if (files.input.empty()) files.missing = below(fs::path(set.input.front()) / set.needs);
  const std::string& import = set.pairs.options.import_descriptors;
  if (import.empty()) return files;
  files.descriptors = below(import);
  if (files.missing.empty() && !fs::is_regular_file(files.descriptors)) files.missing = files.descriptors;
  return files;
}

bool PrepareWarped(const ImageSet& set, const std::string& input, PairsRequest pairs, const std::atomic<bool>& stop) {
  WarpRequest warp;
  warp.input = input;
  warp.output = "runs/warped/" + set.pairs.scene;
  warp.images = set.warp_images;
  warp.views = set.warp_views;
  warp.photograph = set.warp_photograph;
  warp.least_tilt = set.warp_tilt[0];
  warp.greatest_tilt = set.warp_tilt[1];
  if (!WarpImages(warp, stop)) return false;
  std::vector<std::string> folders;
  for (const auto& entry : fs::directory_iterator(warp.output))
    if (entry.is_directory()) folders.push_back(entry.path().string());
  std::sort(folders.begin(), folders.end());
  for (const std::string& folder : folders) {
    pairs.input = folder;
    pairs.scene = set.pairs.scene + "_" + FolderName(folder);
    if (!RunPairs(pairs, stop).finished) return false;
  }
  return true;
}

/// What the converter makes of a set's input. Throws Error.
std::string Converted(const ImageSet& set, const std::string& input) {
  const std::string model = "runs/converted/" + (set.pairs.scene.empty() ? FolderName(input) : set.pairs.scene);
  std::vector<std::string> words = {set.convert, input, set.pairs.format.empty() ? set.output : model};
  if (!set.pairs.scene.empty()) words.insert(words.end(), {"--scene", set.pairs.scene});
  const GivenCalibration& given = set.pairs.calibration;
  if (given.center.size() == 2)
    words.insert(words.end(), {"--focal", std::to_string(given.focal), "--center",
                               std::to_string(given.center[0]) + "," + std::to_string(given.center[1])});
  RunPythonScript("convert.py", words);
  return model;
}

/// The same with descriptors of one kind.
ImageSet Described(ImageSet set, const std::string& features) {
  set.name += "_" + features;
  set.output = "runs/descriptors/" + features + "/" + set.described;
  set.pairs.options.features.kind = FromString<FeatureKind>(features);
  set.pairs.options.descriptors = true;
  return set;
}

}  // namespace

void ImageSet::Bind(OptionsBinder& b) {
  b.Field("name", name).Help("what `--only` calls it");
  b.Field("input", input).Help("folders below the folder of data: the first that is there");
  b.Field("needs", needs).Help("a folder in the input that must be there; empty: the input itself");
  b.Field("output", output).Help("holds the scenes' folders; empty: only those with descriptors are made");
  b.Field("scenes", scenes).Help("which scenes it makes; `*` stands for any text");
  b.Choice("described", described, {"", "test", "train"}).Help("also with descriptors, in runs/descriptors");
  b.Field("warp_images", warp_images, AtLeast(0)).Help("so many images as planes from other places; 0: as they are");
  b.Field("warp_views", warp_views, AtLeast(1)).Help("views of each");
  b.Field("warp_tilt", warp_tilt, Within(0, 89)).Help("of these views, degrees: the least and the greatest");
  b.Require(warp_tilt.size() == 2 && warp_tilt[0] <= warp_tilt[1], "warp_tilt", "two numbers, the smaller first");
  b.Field("warp_photograph", warp_photograph).Help("with a camera's blur, noise, tones and JPEG");
  b.Field("convert", convert).Help("a format of data_tools/convert.py, which makes a COLMAP model or the scenes of it");
  std::vector<std::string> formats = Registry<ImageFormat>::Instance().Names();
  if (!convert.empty()) formats.push_back("");
  b.Choice("format", pairs.format, formats).Help("what the images and their truth come as");
  b.Field("scene", pairs.scene).Help("replaces the name of a single scene");
  b.Field("sequence", pairs.sequence).Help("of KITTI");
  b.Field("steps", pairs.choice.steps, AtLeast(1)).Help("frames between the images of a pair");
  b.Field("every", pairs.choice.every, AtLeast(1)).Help("only every so many images");
  b.Field("pairs_file", pairs.choice.pairs_file)
      .Help("the pairs: the names of two images in each line, of FILE#NAME below the line [NAME]; empty: all");
  b.Field("turn_deg", pairs.choice.turn_deg, Within(0, 180))
      .Help("only cameras so much turned: least and greatest, degrees");
  b.Field("random_pairs", pairs.choice.random_pairs, AtLeast(0)).Help("so many pairs drawn at random; 0: all");
  b.Field("focal", pairs.calibration.focal, AtLeast(0)).Help("of images without calibration, pixels");
  b.Field("center", pairs.calibration.center).Help("principal point, pixels");
  b.Field("import_descriptors", pairs.options.import_descriptors)
      .Help("keypoints and descriptors made elsewhere, an HDF5 file below the folder of data; empty: found here");
  b.Field("max_keypoints", pairs.options.features.max_keypoints, AtLeast(0)).Help("the strongest; 0: all");
  b.Field("max_image_size", pairs.options.features.max_image_size, AtLeast(0))
      .Help("larger images are reduced to this side, pixels; 0: never");
  b.Field("thumbnails", pairs.options.thumbnails).Help("whether small copies of the images are kept for reports");
  b.Field("max_pairs", pairs.options.max_pairs, AtLeast(0)).Help("at most so many a scene, evenly spaced; 0: all");
  b.Field("min_true_matches", pairs.options.min_true_matches, AtLeast(0)).Help("pairs with fewer are left out");
  b.Field("max_disagreement_deg", pairs.options.max_disagreement_deg, AtLeast(0))
      .Help("pairs whose pose turns by more when it is refined on the matches are left out; 0: none");
  b.Field("true_share", pairs.options.true_share, Within(0, 1))
      .Help("only pairs of whose matches such a share is near the truth: least and greatest");
  b.Field("true_match_px", pairs.options.true_match_px, Positive()).Help("what counts as near the truth, pixels");
  b.Require(!name.empty(), "name", "a name");
  b.Require(!input.empty(), "input", "a list of folders");
}

std::vector<ImageSet> ReadImageSets(const std::string& path) {
  std::vector<ImageSet> all;
  for (const ImageSet& set : ReadOptions<ImageSetList>(ConfigFromFile(path)).sets) {
    if (!set.output.empty()) all.push_back(set);
    for (const char* features : kDescribedFeatures)
      if (!set.described.empty()) all.push_back(Described(set, features));
  }
  return all;
}

bool Makes(const ImageSet& set, const std::string& name_or_folder) {
  if (Matches(name_or_folder, set.name)) return true;
  if (name_or_folder == set.output || IsAround(name_or_folder, set.output)) return true;
  return std::any_of(set.scenes.begin(), set.scenes.end(),
                     [&](const std::string& scene) { return Matches(set.output + "/" + scene, name_or_folder); });
}

bool PrepareSets(const SetsRequest& request, const std::atomic<bool>& stop) {
  int made = 0, wanted = 0;
  for (const ImageSet& set : ReadImageSets(request.config)) {
    const auto& only = request.only;
    const bool is_wanted =
        only.empty() || std::any_of(only.begin(), only.end(), [&](const auto& what) { return Makes(set, what); });
    if (!is_wanted) continue;
    ++wanted;
    const SetFiles files = FilesOf(set, request.data);
    if (!files.missing.empty()) {
      LogWarning("left out: " + set.name + ", there is no " + files.missing);
      continue;
    }
    ++made;
    PairsRequest pairs = set.pairs;
    pairs.input = files.input;
    if (!set.convert.empty()) {
      pairs.input = Converted(set, files.input);
      pairs.calibration = {};  // it is in what the converter made
    }
    if (stop) return false;
    if (pairs.format.empty()) continue;
    pairs.output = set.output;
    pairs.options.import_descriptors = files.descriptors;
    pairs.options.threads = request.threads;
    const bool finished =
        set.warp_images > 0 ? PrepareWarped(set, files.input, pairs, stop) : RunPairs(pairs, stop).finished;
    if (!finished) return false;
  }
  if (wanted > 0 && made == 0) throw Error(request.data + ": there are none of the sets that are asked for");
  return true;
}

}  // namespace diffsac
