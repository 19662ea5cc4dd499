#include "diffsac/data/tutorial_dataset.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>

#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "diffsac/data/correspondence_files.h"
#include "diffsac/data/dataset_registry.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

struct SceneFolder {
  std::string name;
  std::string folder;
};

bool HoldsMatches(const fs::path& folder) {
  std::error_code code;
  return fs::exists(folder / "matches.h5", code);
}

std::vector<fs::path> FoldersIn(const fs::path& root) {
  std::vector<fs::path> folders;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(root, code))
    if (entry.is_directory()) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  return folders;
}

// "a/b/" and "." have names too.
std::string NameOf(const fs::path& folder) {
  std::error_code code;
  const fs::path whole = fs::weakly_canonical(folder, code);
  return (code ? folder : whole).filename().string();
}

std::vector<SceneFolder> FindTutorialScenes(const std::string& root, const std::string& split) {
  std::error_code code;
  if (!fs::is_directory(root, code)) throw Error(root + ": no such folder");
  const fs::path inner = fs::path(root) / split;
  if (HoldsMatches(inner)) return {{NameOf(root), inner.string()}};
  std::vector<SceneFolder> scenes;
  for (const fs::path& folder : FoldersIn(inner))
    if (HoldsMatches(folder)) scenes.push_back({NameOf(folder), folder.string()});
  if (scenes.empty())
    for (const fs::path& folder : FoldersIn(root))
      if (HoldsMatches(folder / split)) scenes.push_back({NameOf(folder), (folder / split).string()});
  if (scenes.empty()) throw Error(inner.string() + ": no scenes (folders with matches.h5) of this split");
  return scenes;
}

std::vector<SceneFolder> Chosen(const std::vector<SceneFolder>& found, const std::vector<std::string>& names,
                                const std::string& root) {
  if (names.empty()) return found;
  std::vector<SceneFolder> chosen;
  std::vector<std::string> known;
  for (const SceneFolder& scene : found) known.push_back(scene.name);
  for (const std::string& name : names) {
    const auto at = std::find(known.begin(), known.end(), name);
    if (at == known.end())
      throw Error(root + ": no scene '" + name + "'; did you mean '" + NearestWord(name, known) + "'?");
    chosen.push_back(found[static_cast<std::size_t>(at - known.begin())]);
  }
  return chosen;
}

// The sequence and step in "kitti_00_step_01".
std::optional<std::pair<std::string, int>> ParseKittiScene(const std::string& name) {
  constexpr std::string_view kStart = "kitti_", kMiddle = "_step_";
  const std::size_t middle = name.find(kMiddle);
  if (!name.starts_with(kStart) || middle == std::string::npos) return {};
  int step = 0;
  const char* end = name.data() + name.size();
  const auto read = std::from_chars(name.data() + middle + kMiddle.size(), end, step);
  if (read.ec != std::errc() || read.ptr != end) return {};
  return std::pair(name.substr(kStart.size(), middle - kStart.size()), step);
}

template <class Item>
bool Wanted(const std::vector<Item>& wanted, const Item& item) {
  return wanted.empty() || std::find(wanted.begin(), wanted.end(), item) != wanted.end();
}

CorrespondencesOptions AsCorrespondences(const PairStreamOptions& options) {
  CorrespondencesOptions result;
  result.task = options.task;
  result.inlier_threshold_px = options.inlier_threshold_px;
  result.max_ratio = options.snn_threshold;
  result.max_points = options.max_points;
  result.cap = options.cap;
  result.shuffle_points = options.shuffle_points;
  result.refine_truth_px = options.refine_truth_px;
  result.dominant_plane = options.dominant_plane;
  result.descriptor_noise = options.descriptor_noise;
  return result;
}

class PairStream : public Dataset {
 public:
  PairStream(const std::vector<SceneFolder>& folders, const PairStreamOptions& options, std::uint64_t seed)
      : options_(options), conversion_(AsCorrespondences(options)), task_(TaskFromString(options.task)) {
    for (const SceneFolder& folder : folders) {
      CorrespondenceScene scene(folder.folder, {options.inlier_threshold_px, options.descriptors});
      for (std::int64_t position : EvenlySpread(scene.size(), options.max_pairs))
        pairs_.push_back({static_cast<std::uint32_t>(scenes_.size()), static_cast<std::uint32_t>(position)});
      scenes_.push_back({folder.name, std::move(scene)});
    }
    if (!options.shuffle) return;
    const std::vector<int> order = Rng(seed).Fork("shuffled_pairs").Permutation(static_cast<int>(pairs_.size()));
    std::vector<Place> shuffled;
    for (int i : order) shuffled.push_back(pairs_[i]);
    pairs_ = std::move(shuffled);
  }

  Task task() const override { return task_; }
  std::int64_t size() const override { return static_cast<std::int64_t>(pairs_.size()); }

  Example Get(std::uint64_t index) const override {
    if (index >= pairs_.size()) throw Error("there is no pair " + std::to_string(index) + " in this data");
    const Place& place = pairs_[index];
    const Scene& scene = scenes_[place.scene];
    TwoViewExample pair = scene.files.Read(place.position);
    const std::string where = scene.files.folder() + "/matches.h5: " + pair.id;
    if (pair.problem.points.rows() == 0 && options_.empty_pairs == "error")
      throw Error(where + ": no matches (empty_pairs: keep accepts that)");
    if (task_ == Task::kEssential && !pair.problem.calibrated)
      throw Error(where + ": no calibration (K1_K2.h5), which task essential needs");
    pair.scene = scene.name;
    Example example = ToExample(pair, task_, conversion_);
    example.index = index;
    return example;
  }

 private:
  struct Scene {
    std::string name;
    CorrespondenceScene files;
  };
  struct Place {
    std::uint32_t scene, position;
  };

  PairStreamOptions options_;
  CorrespondencesOptions conversion_;
  Task task_;
  std::vector<Scene> scenes_;
  std::vector<Place> pairs_;
};

}  // namespace

void PairStreamOptions::Bind(OptionsBinder& b) {
  b.Choice("task", task, {"homography", "fundamental", "essential"});
  b.Field("inlier_threshold_px", inlier_threshold_px, Positive());
  b.Field("snn_threshold", snn_threshold, Positive());
  b.Field("max_points", max_points, AtLeast(0));
  b.Choice("cap", cap, {"best", "random"});
  b.Field("shuffle_points", shuffle_points);
  b.Field("max_pairs", max_pairs, AtLeast(0));
  b.Field("refine_truth_px", refine_truth_px, AtLeast(0.0));
  b.Field("dominant_plane", dominant_plane);
  b.Field("shuffle", shuffle);
  b.Choice("empty_pairs", empty_pairs, {"error", "keep"});
  b.Field("descriptors", descriptors);
  b.Field("descriptor_noise", descriptor_noise, AtLeast(0.0));
}

void RansacTutorialOptions::Bind(OptionsBinder& b) {
  b.Field("root", root);
  b.Choice("split", split, {"train", "val", "test", "validation"});
  b.Field("scenes", scenes);
  pairs.Bind(b);
  b.Require(!root.empty(), "root", "a folder");
}

void KittiOptions::Bind(OptionsBinder& b) {
  b.Field("root", root);
  b.Field("sequences", sequences);
  b.Field("steps", steps, AtLeast(1));
  pairs.Bind(b);
  b.Require(!root.empty(), "root", "a folder");
}

std::unique_ptr<Dataset> MakeRansacTutorial(const RansacTutorialOptions& options, std::uint64_t seed) {
  const auto found = FindTutorialScenes(options.root, options.split == "validation" ? "val" : options.split);
  return std::make_unique<PairStream>(Chosen(found, options.scenes, options.root), options.pairs, seed);
}

std::unique_ptr<Dataset> MakeKitti(const KittiOptions& options, std::uint64_t seed) {
  std::error_code code;
  if (!fs::is_directory(options.root, code)) throw Error(options.root + ": no such folder");
  std::vector<SceneFolder> scenes;
  for (const fs::path& folder : FoldersIn(options.root)) {
    const auto scene = ParseKittiScene(NameOf(folder));
    if (scene && HoldsMatches(folder) && Wanted(options.sequences, scene->first) &&
        Wanted(options.steps, scene->second))
      scenes.push_back({NameOf(folder), folder.string()});
  }
  if (scenes.empty())
    throw Error(options.root +
                ": no scenes kitti_<sequence>_step_<step> of these sequences and steps (diffsac_prepare "
                "makes them)");
  return std::make_unique<PairStream>(scenes, options.pairs, seed);
}

namespace {

const RegisteredDataset<RansacTutorialOptions> kRansacTutorial(
    "ransac_tutorial", DataSource::kFiles, "The CVPR 2020 RANSAC tutorial's correspondence files.", MakeRansacTutorial);
const RegisteredDataset<KittiOptions> kKitti(
    "kitti", DataSource::kFiles, "KITTI odometry as `diffsac_prepare pairs --format kitti` writes it.", MakeKitti);

}  // namespace

}  // namespace diffsac
