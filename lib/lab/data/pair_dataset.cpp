#include "lab/data/pair_dataset.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "diffsac/core/nearest_word.h"
#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/fitted_truth.h"
#include "lab/data/pair_check.h"
#include "lab/data/pair_filter.h"
#include "lab/data/pair_reading.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {
namespace {

PairReadingOptions ReadingOf(const PairsOptions& options) {
  const bool plane = options.dominant_plane && options.task == Task::kHomography;
  const double threshold = options.inlier_threshold_px;
  return {options.descriptors, options.refine_truth_px, plane ? threshold : 0.0, options.instances ? threshold : 0.0,
          options.task};
}

// The part of a scene's pairs that is asked for, thinned to `max_pairs`.
std::vector<std::int64_t> PairsOf(std::int64_t size, const PairsOptions& options) {
  const auto at = [&](double share) {
    return static_cast<std::int64_t>(std::llround(share * static_cast<double>(size)));
  };
  const std::int64_t first = at(options.part.low);
  std::vector<std::int64_t> positions = EvenlySpread(at(options.part.high) - first, options.max_pairs);
  for (std::int64_t& position : positions) position += first;
  return positions;
}

bool HasLabels(const Example& pair) {
  return static_cast<Eigen::Index>(pair.truth.assignment.size()) == pair.problem.points.rows();
}

// A view of the pairs of some scenes: filtered, as problems of one task.
class PairDataset : public Dataset {
 public:
  PairDataset(const std::vector<SceneFolder>& folders, const PairsOptions& options, bool in_memory, std::uint64_t seed)
      : options_(options), task_(options.task), folders_(folders) {
    for (const SceneFolder& folder : folders) AddScene(folder, in_memory);
    if (places_.empty())
      throw Error((folders.empty() ? std::string("correspondences") : folders.front().folder) +
                  ": no pairs with at least " + std::to_string(options.min_points) + " matches in the given scenes");
    CheckSome();
    if (!options.shuffle) return;
    const std::vector<int> order = Rng(seed).Fork("shuffled_pairs").Permutation(static_cast<int>(places_.size()));
    std::vector<Place> shuffled;
    for (int i : order) shuffled.push_back(places_[i]);
    places_ = std::move(shuffled);
  }

  Task task() const override { return task_; }
  std::int64_t size() const override { return static_cast<std::int64_t>(places_.size()); }

  Example Get(std::uint64_t index) const override {
    if (index >= places_.size()) throw Error("there is no pair " + std::to_string(index) + " in this data");
    Example example = Filtered(*Pair(places_[index]), options_.filter);
    SetTask(task_, options_.inlier_threshold_px, &example);
    if (options_.instances) ArrangeInstancesOf(task_, &example.truth);
    example.index = index;
    return example;
  }

  std::string FolderOf(const std::string& scene) const override {
    for (const SceneFolder& folder : folders_)
      if (folder.name == scene) return folder.folder;
    return "";
  }

 private:
  struct Place {
    std::uint32_t scene, position;
  };

  void AddScene(const SceneFolder& folder, bool in_memory) {
    const auto scene = static_cast<std::uint32_t>(scenes_.size());
    scenes_.push_back(PairReading::Open(folder, ReadingOf(options_)));
    for (const std::int64_t position : PairsOf(scenes_.back()->size(), options_)) {
      const Place place{scene, static_cast<std::uint32_t>(position)};
      if (in_memory || options_.min_points > 0) {
        const std::shared_ptr<const Example> pair = Pair(place);
        if (static_cast<int>(KeptRows(*pair, options_.filter).size()) < options_.min_points) continue;
        if (in_memory) held_.push_back(pair);
      }
      places_.push_back(place);
    }
    if (in_memory) scenes_.back()->CloseFiles();
  }

  /// In the first seconds: some pairs, evenly spread.
  void CheckSome() const {
    constexpr int kLookedAt = 64;
    std::map<std::uint32_t, PairCheck> checks;
    for (const std::int64_t i : EvenlySpread(size(), kLookedAt)) {
      const Place& place = places_[static_cast<std::size_t>(i)];
      try {
        checks.try_emplace(place.scene, options_).first->second.Add(scenes_[place.scene]->Raw(place.position));
      } catch (const Error&) {
        continue;  // Said when the pair is asked for.
      }
    }
    for (const auto& [scene, check] : checks) {
      check.Tell(scenes_[scene]->folder());
      scenes_[scene]->CloseFiles();
    }
  }

  std::shared_ptr<const Example> Pair(const Place& place) const {
    const PairReading& scene = *scenes_[place.scene];
    std::shared_ptr<const Example> pair = scene.Pair(place.position);
    if (pair->problem.points.rows() == 0 && options_.empty_pairs == EmptyPairs::kError)
      throw Error(scene.Where(place.position) + ": no matches (empty_pairs: keep accepts that)");
    if ((task_ == Task::kEssential || task_ == Task::kOneFocal) && !pair->problem.cameras)
      throw Error(scene.Where(place.position) + ": no calibration (K1_K2.h5), which task " + ToString(task_) +
                  " needs");
    if (options_.instances && !HasLabels(*pair))
      throw Error(scene.Where(place.position) + ": no labels (labels.h5), which structures: true needs");
    return pair;
  }

  PairsOptions options_;
  Task task_;
  std::vector<SceneFolder> folders_;
  std::vector<std::shared_ptr<const PairReading>> scenes_;
  std::vector<Place> places_;
  std::vector<std::shared_ptr<const Example>> held_;
};

}  // namespace

void PairsOptions::Bind(OptionsBinder& b, const char* ratio_key) {
  b.Field("task", task, kTwoViewTasks).Help("what is estimated");
  b.Field("inlier_threshold_px", inlier_threshold_px, Positive()).Help("ε, linear, pixels");
  b.Field(ratio_key, filter.max_ratio, Positive())
      .Help("only matches whose ratio (match_conf.h5) is at most this; 1 keeps all, and so does data without ratios");
  b.Field("ratios", filter.ratios)
      .Help("whether matches keep their ratios; false: as matches that nobody rated, ordered and filtered by nothing");
  b.Field("similarities", filter.scale_rotation_changes)
      .Help("whether matches keep how their keypoints differ in size and angle (similarities.h5)");
  b.Field("max_points", filter.max_points, AtLeast(0)).Help("at most so many matches a pair; 0 keeps all");
  b.Field("cap", filter.cap)
      .OnlyIf(filter.max_points > 0, "max_points above 0")
      .Help("which: the best by ratio (the first without ratios), or random ones");
  b.Field("shuffle_points", filter.shuffle_points)
      .Help("matches in random order; this and `cap: random` depend on the pair's scene and id alone");
  b.Field("min_points", min_points, AtLeast(0))
      .Help("only pairs with at least so many matches left; more than 0 reads all pairs at the start");
  b.Field("part", part, Within(0.0, 1.0))
      .Help("the part of each scene's pairs, in the order of their names: [0.8, 1] is the last fifth");
  b.Field("max_pairs", max_pairs, AtLeast(0)).Help("at most so many pairs of it, evenly spread; 0 keeps all");
  b.Field("refine_truth_px", refine_truth_px, AtLeast(0.0))
      .Help("the truth is first refined on the matches near it, truncated at so many pixels (poses stay); 0: as given");
  b.Field("dominant_plane", dominant_plane)
      .OnlyIf(task == Task::kHomography, "task: homography")
      .Help("the homography of a pair that has a pose alone: the one that most true matches follow");
  b.Field("structures", instances)
      .OnlyIf(task == Task::kHomography || task == Task::kFundamental, "task: homography or fundamental")
      .Help(
          "several models at once: of each label (labels.h5) the homography of at least five matches, or the "
          "fundamental matrix of at least eight");
  b.Require(!instances || !dominant_plane, "structures", "either this or dominant_plane, not both");
  b.Field("shuffle", shuffle).Help("pairs of all scenes in one random order, by the seed; else scene by scene");
  b.Field("empty_pairs", empty_pairs)
      .Help("a pair without matches: an error that names file and key, or a problem without points");
  b.Field("descriptors", descriptors).Help("whether descriptors.h5 is read where it is there");
  b.Field("descriptor_noise", filter.descriptor_noise, AtLeast(0.0))
      .OnlyIf(descriptors, "descriptors: true")
      .Help("normal noise on each descriptor's values, in multiples of their root mean square");
}

std::unique_ptr<Dataset> MakePairDataset(const std::vector<SceneFolder>& scenes, const PairsOptions& options,
                                         PairMemory memory, std::uint64_t seed) {
  return std::make_unique<PairDataset>(scenes, options, memory == PairMemory::kAll, seed);
}

void CorrespondencesOptions::Bind(OptionsBinder& b) {
  b.Field("paths", paths).Help("folders of correspondence files, or folders of such folders; a scene each");
  pairs.Bind(b, "max_ratio");
}

std::unique_ptr<Dataset> MakeCorrespondences(const CorrespondencesOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  return MakePairDataset(FindScenes(options.paths), options.pairs, PairMemory::kAll, seed);
}

const RegisteredDataset<CorrespondencesOptions> kCorrespondences(
    "correspondences", DataSource::kFiles,
    "Correspondence files, as `diffsac_prepare` writes them; all pairs are read at the start and kept.",
    MakeCorrespondences);

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

std::vector<SceneFolder> FindKittiScenes(const KittiOptions& options) {
  std::vector<SceneFolder> scenes = FoldersIn(options.root);
  std::erase_if(scenes, [&](const SceneFolder& folder) {
    const auto scene = ParseKittiScene(folder.name);
    return !scene || !HoldsMatches(folder.folder) || !Wanted(options.sequences, scene->first) ||
           !Wanted(options.steps, scene->second);
  });
  if (scenes.empty())
    throw Error(options.root +
                ": no scenes kitti_<sequence>_step_<step> of these sequences and steps (diffsac_prepare makes them)");
  return scenes;
}

void KittiOptions::Bind(OptionsBinder& b) {
  b.Field("root", root).Help("a folder with scenes kitti_<sequence>_step_<step>");
  b.Field("sequences", sequences).Help("empty: all");
  b.Field("steps", steps, AtLeast(1)).Help("frames between the images of a pair; empty: all");
  pairs.Bind(b, "snn_threshold");
  b.Require(!root.empty(), "root", "a folder");
}

std::unique_ptr<Dataset> MakeKitti(const KittiOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  return MakePairDataset(FindKittiScenes(options), options.pairs, PairMemory::kRecent, seed);
}

const RegisteredDataset<KittiOptions> kKitti(
    "kitti", DataSource::kFiles,
    "KITTI odometry as `diffsac_prepare pairs --format kitti` writes it; a pair is read when it is asked for.",
    MakeKitti);

std::vector<SceneFolder> AllScenes(const std::string& root, const std::string& split) {
  const std::vector<SceneFolder> folders = FoldersIn(root);
  const std::string inner = root + "/" + split;
  if (HoldsMatches(inner)) return {{NamedFolder(root).name, inner}};
  std::vector<SceneFolder> scenes;
  std::error_code code;
  if (std::filesystem::is_directory(inner, code)) scenes = FoldersIn(inner);
  std::erase_if(scenes, [](const SceneFolder& scene) { return !HoldsMatches(scene.folder); });
  if (scenes.empty())
    for (const auto& [name, folder] : folders)
      if (HoldsMatches(folder + "/" + split)) scenes.push_back({name, folder + "/" + split});
  if (scenes.empty()) throw Error(inner + ": no scenes (folders with matches.h5) of this split");
  return scenes;
}

std::vector<SceneFolder> ChosenScenes(const RansacTutorialOptions& options) {
  const auto found = AllScenes(options.root, options.split == "validation" ? "val" : options.split);
  if (options.scenes.empty()) return found;
  std::vector<SceneFolder> chosen;
  std::vector<std::string> known;
  for (const SceneFolder& scene : found) known.push_back(scene.name);
  for (const std::string& name : options.scenes) {
    const auto at = std::find(known.begin(), known.end(), name);
    if (at == known.end())
      throw Error(options.root + ": no scene '" + name + "'; did you mean '" + NearestWord(name, known) + "'?");
    chosen.push_back(found[static_cast<std::size_t>(at - known.begin())]);
  }
  return chosen;
}

void RansacTutorialOptions::Bind(OptionsBinder& b) {
  b.Field("root", root).Help("a folder: <root>/<split>/<scene>, or <root>/<scene>/<split>");
  b.Choice("split", split, {"train", "val", "test", "validation"}).Help("the folder; validation means val");
  b.Field("scenes", scenes).Help("names; empty: all");
  pairs.Bind(b, "snn_threshold");
  b.Require(!root.empty(), "root", "a folder");
}

std::unique_ptr<Dataset> MakeRansacTutorial(const RansacTutorialOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  return MakePairDataset(ChosenScenes(options), options.pairs, PairMemory::kRecent, seed);
}

const RegisteredDataset<RansacTutorialOptions> kRansacTutorial(
    "ransac_tutorial", DataSource::kFiles,
    "The CVPR 2020 RANSAC tutorial's correspondence files; a pair is read when it is asked for.", MakeRansacTutorial);

}  // namespace diffsac
