#include "lab/images/run_pairs.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/config/progress.h"
#include "lab/data/fitted_truth.h"
#include "lab/data/pair_scenes.h"
#include "lab/eval/digest.h"
#include "lab/files/correspondence_files.h"
#include "lab/files/files.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/images/feature_store.h"
#include "lab/images/match_pair.h"
#include "lab/images/pictures.h"

namespace diffsac {

namespace fs = std::filesystem;

namespace {

std::vector<SourcePair> EvenlySpaced(const std::vector<SourcePair>& pairs, int max_pairs) {
  std::vector<SourcePair> chosen;
  for (const std::int64_t position : EvenlySpread(static_cast<std::int64_t>(pairs.size()), max_pairs))
    chosen.push_back(pairs[static_cast<std::size_t>(position)]);
  return chosen;
}

// The descriptors of matches.
DescriptorMatrix RowsOf(const FeatureStore& store, const SourcePair& pair,
                        const std::vector<DescriptorMatch>& matches) {
  const DescriptorMatrix first = store.Load(pair.image1).descriptors, second = store.Load(pair.image2).descriptors;
  DescriptorMatrix rows(static_cast<Eigen::Index>(matches.size()), first.cols() + second.cols());
  for (std::size_t i = 0; i < matches.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) << first.row(matches[i].first), second.row(matches[i].second);
  return rows;
}

// What decides the content of a scene's files: it stands in the scene's folder, so that a later call can tell whether
// that is what it would make.
std::string RecipeOf(const ImageSource& source, const SourceScene& scene, const PrepareOptions& options) {
  const FeatureOptions& features = options.features;
  std::ostringstream text;
  if (options.import_descriptors.empty()) {
    text << "features " << ToString(features.kind) << "\ncontrast_threshold " << kContrastThreshold
         << "\nmax_image_size " << features.max_image_size << "\nsimilarities 1\n";
  } else {
    text << "features " << fs::path(options.import_descriptors).filename().string() << "\n";
  }
  text << "max_keypoints " << features.max_keypoints << "\ndescriptors " << options.descriptors << "\nmin_true_matches "
       << options.min_true_matches << "\ntrue_match_px " << options.true_match_px << "\npairs " << scene.pairs.size()
       << "\n";
  if (!options.true_share.empty())
    text << "true_share " << options.true_share[0] << " " << options.true_share[1] << "\n";
  if (options.max_disagreement_deg > 0.0) text << "max_disagreement_deg " << options.max_disagreement_deg << "\n";
  std::string pairs;
  for (const SourcePair& pair : scene.pairs)
    pairs += source.images[pair.image1].name + "-" + source.images[pair.image2].name + "\n";
  // The last line, which recipes of before version 0.2 do not have.
  text << "pair_list " << DigestOfText(pairs) << "\n";
  return text.str();
}

constexpr const char* kRecipeFile = "prepared.txt";

class Preparation {
 public:
  Preparation(const ImageSource& source, const PrepareOptions& options, const std::string& output,
              const std::atomic<bool>& stop)
      : source_(source),
        options_(options),
        output_(output),
        stop_(stop),
        store_(source, options.features, options.import_descriptors, CacheFolder(source, output)),
        broken_(source.images.size(), 0) {}

  PrepareResult Run();

 private:
  static std::string CacheFolder(const ImageSource& source, const std::string& output) {
    return (fs::path(output) / (".keypoints-" + source.scenes.at(0).name)).string();
  }
  std::string FolderOf(const SourceScene& scene) const { return (fs::path(output_) / scene.name).string(); }

  bool IsThere(const SourceScene& scene) const;
  bool PrepareImages(const std::vector<SourceScene>& scenes);
  void LeaveOut(const std::string& problem);
  bool MatchScene(const SourceScene& scene, std::vector<MatchedPair>* matched) const;
  bool WriteScene(const SourceScene& scene);
  bool IsKept(const MatchedPair& matched) const;
  CorrespondenceSet Collect(const SourceScene& scene, std::vector<MatchedPair>* matched,
                            std::vector<std::size_t>* kept) const;

  const ImageSource& source_;
  const PrepareOptions& options_;
  std::string output_;
  const std::atomic<bool>& stop_;
  FeatureStore store_;
  std::vector<char> broken_;  // images
  PrepareResult result_;
  std::vector<std::string> empty_scenes_;
};

bool Preparation::IsThere(const SourceScene& scene) const {
  const fs::path folder = FolderOf(scene);
  std::error_code code;
  if (options_.overwrite || !fs::exists(folder / "matches.h5", code)) return false;
  std::string text = folder.string() + ": already there";
  const std::string recipe = (folder / kRecipeFile).string();
  if (fs::exists(recipe, code) && !RecipeOf(source_, scene, options_).starts_with(ReadFile(recipe))) {
    LogWarning(text + ", but made in another way (" + recipe + "); --overwrite makes it again");
  } else {
    LogInfo(text);
  }
  return true;
}

void Preparation::LeaveOut(const std::string& problem) {
  LogWarning("left out: " + problem);
  result_.left_out.push_back(problem);
}

// Returns false when it was stopped.
bool Preparation::PrepareImages(const std::vector<SourceScene>& scenes) {
  std::set<int> needed;
  for (const SourceScene& scene : scenes)
    for (const SourcePair& pair : scene.pairs) needed.insert({pair.image1, pair.image2});
  const std::vector<int> images(needed.begin(), needed.end());
  std::vector<std::string> problems;
  if (!store_.PrepareAll(images, options_.threads, stop_, &problems)) return false;
  for (std::size_t k = 0; k < images.size(); ++k) {
    if (problems[k].empty()) continue;
    broken_[images[k]] = 1;
    LeaveOut(problems[k]);
  }
  return true;
}

bool Preparation::MatchScene(const SourceScene& scene, std::vector<MatchedPair>* matched) const {
  Progress progress(scene.name, static_cast<std::int64_t>(scene.pairs.size()));
  return ForEachPair(store_, scene.pairs, options_.threads, stop_,
                     [&](std::int64_t i, const ImageFeatures& first, const ImageFeatures& second) {
                       (*matched)[i] = MatchPair(source_, scene.pairs[i], first, second, store_.distance());
                       progress.Advance();
                     });
}

bool Preparation::IsKept(const MatchedPair& matched) const {
  const Problem& problem = matched.example.problem;
  const GroundTruth& truth = matched.example.truth;
  if (options_.min_true_matches > 0 || !options_.true_share.empty()) {
    const Eigen::VectorXd distances = TruthDistances(problem, truth);
    const auto near = static_cast<double>((distances.array() <= options_.true_match_px).count());
    if (near < options_.min_true_matches) return false;
    const double share = near / static_cast<double>(std::max<Eigen::Index>(1, distances.size()));
    if (!options_.true_share.empty() && (share < options_.true_share[0] || share > options_.true_share[1]))
      return false;
  }
  if (options_.max_disagreement_deg == 0.0) return true;
  return TruthDisagreementDegrees(problem, truth, options_.true_match_px, options_.min_true_matches) <=
         options_.max_disagreement_deg;
}

CorrespondenceSet Preparation::Collect(const SourceScene& scene, std::vector<MatchedPair>* matched,
                                       std::vector<std::size_t>* kept) const {
  CorrespondenceSet set;
  for (std::size_t i = 0; i < matched->size(); ++i) {
    if (!IsKept((*matched)[i])) continue;
    kept->push_back(i);
    set.pairs.push_back(std::move((*matched)[i].example));
    for (int image : {scene.pairs[i].image1, scene.pairs[i].image2})
      if (source_.images[image].pose) set.cameras[source_.images[image].name] = *source_.images[image].pose;
  }
  return set;
}

bool Preparation::WriteScene(const SourceScene& asked) {
  SourceScene scene = asked;
  std::erase_if(scene.pairs, [&](const SourcePair& pair) { return broken_[pair.image1] || broken_[pair.image2]; });
  std::vector<MatchedPair> matched(scene.pairs.size());
  if (!MatchScene(scene, &matched)) return false;
  std::vector<std::size_t> kept;
  CorrespondenceSet set = Collect(scene, &matched, &kept);
  if (kept.empty()) {
    empty_scenes_.push_back(scene.name + (scene.pairs.empty()
                                              ? ": no pair of images that can be read"
                                              : ": no pair has enough true matches or a pose that agrees with them"));
    return true;
  }
  if (options_.descriptors)
    set.descriptors = [&](std::size_t i) { return RowsOf(store_, scene.pairs[kept[i]], matched[kept[i]].matches); };
  const std::string folder = FolderOf(scene);
  MakeWritableFolder(folder);
  // Before the first word of the new recipe is there, the old files must be incomplete.
  RemoveFile((fs::path(folder) / "matches.h5").string());
  WriteFileAtomically((fs::path(folder) / kRecipeFile).string(), RecipeOf(source_, asked, options_));
  RemoveFile((fs::path(folder) / kThumbnailsFile).string());
  if (options_.thumbnails) WriteThumbnailsOf(source_, set.pairs, options_.threads, folder);
  WriteCorrespondences(folder, set);
  LogInfo(folder + ": " + std::to_string(kept.size()) + " of " + std::to_string(asked.pairs.size()) + " pairs");
  result_.written += 1;
  return true;
}

PrepareResult Preparation::Run() {
  for (const LeftOutImage& image : source_.left_out) LeaveOut(image.problem);
  std::vector<SourceScene> scenes = source_.scenes;
  for (SourceScene& scene : scenes) scene.pairs = EvenlySpaced(scene.pairs, options_.max_pairs);
  result_.already_there =
      static_cast<int>(std::erase_if(scenes, [&](const SourceScene& scene) { return IsThere(scene); }));
  result_.finished = PrepareImages(scenes);
  for (std::size_t i = 0; i < scenes.size() && result_.finished; ++i) result_.finished = WriteScene(scenes[i]);
  if (!result_.left_out.empty())
    LogWarning(std::to_string(result_.left_out.size()) + " of " +
               std::to_string(source_.images.size() + source_.left_out.size()) + " images were left out");
  if (!result_.finished) return result_;
  store_.RemoveCache();
  if (!empty_scenes_.empty())
    throw Error(empty_scenes_[0] + (result_.left_out.empty() ? "" : " (" + result_.left_out[0] + ")"));
  return result_;
}

}  // namespace

void PrepareOptions::Check() const {
  features.Check();
  if (max_pairs < 0 || min_true_matches < 0 || threads < 0)
    throw Error("max_pairs, min_true_matches and threads must not be negative");
  if (!(max_disagreement_deg >= 0.0)) throw Error("max_disagreement_deg must not be negative");
  if (!true_share.empty() && !(true_share.size() == 2 && true_share[0] >= 0.0 && true_share[0] <= true_share[1]))
    throw Error("true_share: expected two numbers, the smaller first");
  if (!(true_match_px > 0.0)) throw Error("true_match_px must be positive");
}

PrepareResult PreparePairs(const ImageSource& source, const PrepareOptions& options, const std::string& output,
                           const std::atomic<bool>& stop) {
  options.Check();
  // Before minutes of work.
  MakeWritableFolder(output);
  if (source.scenes.empty()) return {};
  return Preparation(source, options, output, stop).Run();
}

namespace {

// Options that the format would not look at are mistakes.
void CheckRequest(const PairsRequest& request, const ImageFormat& format) {
  const GivenCalibration& given = request.calibration;
  if (given.IsGiven() && !format.takes_calibration)
    throw Error("--calibration, --focal and --center are for images without one; " + request.format + " has its own");
  if (format.takes_sequence && request.sequence.empty())
    throw Error("--sequence is needed for " + request.format + " (00, 01, ...)");
  if (!format.takes_sequence && !request.sequence.empty()) throw Error("--sequence is not for " + request.format);
  if (request.ratios && !format.takes_ratios) throw Error("--ratios is not for " + request.format);
  if (!request.choice.IsAll() && format.write)
    throw Error(request.input + ": the pairs of this format cannot be chosen");
}

}  // namespace

void RefuseInputsInScene(const PairsRequest& request, const std::string& folder) {
  std::error_code code;
  for (const fs::path input : {request.input, request.options.import_descriptors}) {
    const fs::path holder = fs::absolute(input, code).parent_path();
    if (!input.empty() && input.extension() == ".h5" && fs::equivalent(holder, folder, code))
      throw Error("'" + input.string() + "' is an input, and would be replaced in the folder of the scene '" + folder +
                  "': give another --output or --scene");
  }
}

PrepareResult RunPairs(const PairsRequest& request, const std::atomic<bool>& stop) {
  const ImageFormat& format = Registry<ImageFormat>::Instance().Find(request.format, "--format");
  CheckRequest(request, format);
  if (format.write) return format.write(request, stop);
  ImageSource source = format.read(request);
  if (!format.chooses_pairs) ChoosePairs(request.choice, request.input, &source);
  if (!request.scene.empty()) {
    if (source.scenes.size() != 1)
      throw Error("--scene: the source has " + std::to_string(source.scenes.size()) + " scenes");
    source.scenes[0].name = request.scene;
  }
  for (const SourceScene& scene : source.scenes)
    RefuseInputsInScene(request, (fs::path(request.output) / scene.name).string());
  return PreparePairs(source, request.options, request.output, stop);
}

}  // namespace diffsac
