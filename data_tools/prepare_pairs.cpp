#include "data_tools/prepare_pairs.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <numeric>

#include "data_tools/adelaide_rmf.h"
#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/progress.h"
#include "diffsac/core/status.h"
#include "diffsac/data/correspondence_files.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

std::vector<SourcePair> EvenlySpaced(const std::vector<SourcePair>& pairs, int max_pairs) {
  if (max_pairs == 0 || static_cast<int>(pairs.size()) <= max_pairs) return pairs;
  std::vector<SourcePair> chosen;
  for (std::int64_t i = 0; i < max_pairs; ++i)
    chosen.push_back(pairs[static_cast<std::size_t>(i * static_cast<std::int64_t>(pairs.size()) / max_pairs)]);
  return chosen;
}

// Equal correspondences say one thing: the one with the best ratio stays. Keeps the order.
std::vector<DescriptorMatch> WithoutRepeats(const std::vector<DescriptorMatch>& matches, const ImageFeatures& first,
                                            const ImageFeatures& second) {
  using Position = std::array<double, 4>;
  std::map<Position, std::size_t> best;
  const auto position = [&](const DescriptorMatch& m) {
    return Position{first.positions(m.first, 0), first.positions(m.first, 1), second.positions(m.second, 0),
                    second.positions(m.second, 1)};
  };
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const auto [entry, is_new] = best.try_emplace(position(matches[i]), i);
    if (!is_new && matches[i].ratio < matches[entry->second].ratio) entry->second = i;
  }
  std::vector<DescriptorMatch> kept;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (best.at(position(matches[i])) == i) kept.push_back(matches[i]);
  return kept;
}

// One pair, matched.
struct MatchedPair {
  TwoViewExample example;
  std::vector<DescriptorMatch> matches;
  bool kept = false;
};

class Preparation {
 public:
  Preparation(const ImageSource& source, const PrepareOptions& options, const std::string& output,
              const std::atomic<bool>& stop)
      : source_(source), options_(options), output_(output), stop_(stop), features_(source.images.size()) {}

  bool Run();

 private:
  bool ExtractAll(const std::vector<SourceScene>& scenes);
  bool WriteScene(const SourceScene& scene);
  MatchedPair MatchPair(const SourcePair& pair) const;
  void FillProblem(const SourcePair& pair, MatchedPair* matched) const;
  void FillTruth(const SourcePair& pair, TwoViewExample* example) const;
  DescriptorMatrix DescriptorsOf(const SourcePair& pair, const std::vector<DescriptorMatch>& matches) const;
  CorrespondenceSet Collect(const SourceScene& scene, std::vector<MatchedPair>* matched,
                            std::vector<std::size_t>* kept) const;

  const ImageSource& source_;
  const PrepareOptions& options_;
  std::string output_;
  const std::atomic<bool>& stop_;
  std::vector<ImageFeatures> features_;
};

bool Preparation::ExtractAll(const std::vector<SourceScene>& scenes) {
  std::vector<char> needed(source_.images.size(), 0);
  for (const SourceScene& scene : scenes)
    for (const SourcePair& pair : scene.pairs) needed[pair.image1] = needed[pair.image2] = 1;
  std::vector<int> images;
  for (std::size_t i = 0; i < needed.size(); ++i)
    if (needed[i] != 0) images.push_back(static_cast<int>(i));
  Progress progress("keypoints", static_cast<std::int64_t>(images.size()));
  ParallelFor(static_cast<std::int64_t>(images.size()), options_.threads, [&](std::int64_t k) {
    if (stop_) return;
    const SourceImage& image = source_.images[images[k]];
    ImageFeatures& features = features_[images[k]];
    features = ExtractRootSift(image.path, options_.features);
    if (image.camera && image.camera->size != ImageSize{} && image.camera->size != features.size)
      throw Error(image.path + ": is " + std::to_string(features.size.width) + "x" +
                  std::to_string(features.size.height) + ", but its calibration is for " +
                  std::to_string(image.camera->size.width) + "x" + std::to_string(image.camera->size.height));
    progress.Advance();
  });
  return !stop_;
}

void Preparation::FillProblem(const SourcePair& pair, MatchedPair* matched) const {
  const SourceImage &image1 = source_.images[pair.image1], &image2 = source_.images[pair.image2];
  const ImageFeatures &first = features_[pair.image1], &second = features_[pair.image2];
  const auto position = [](const SourceImage& image, const ImageFeatures& features, int row) -> Eigen::RowVector2d {
    const Eigen::Vector2d pixel = features.positions.row(row);
    return (image.camera ? image.camera->Undistort(pixel) : pixel).transpose();
  };
  TwoViewProblem& problem = matched->example.problem;
  const auto count = static_cast<Eigen::Index>(matched->matches.size());
  problem.points.resize(count, 4);
  problem.quality.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const DescriptorMatch& match = matched->matches[i];
    problem.points.row(i) << position(image1, first, match.first), position(image2, second, match.second);
    problem.quality[i] = match.ratio;
  }
  problem.size1 = first.size;
  problem.size2 = second.size;
  problem.calibrated = image1.camera && image2.camera;
  if (problem.calibrated) {
    problem.K1 = image1.camera->K;
    problem.K2 = image2.camera->K;
  }
}

void Preparation::FillTruth(const SourcePair& pair, TwoViewExample* example) const {
  const auto &pose1 = source_.images[pair.image1].pose, &pose2 = source_.images[pair.image2].pose;
  if (pose1 && pose2) example->truth.motion = RelativeMotion(*pose1, *pose2);
  example->truth.homography = pair.homography;
  CompleteTruth(example->problem, &example->truth);
}

MatchedPair Preparation::MatchPair(const SourcePair& pair) const {
  MatchedPair matched;
  const ImageFeatures &first = features_[pair.image1], &second = features_[pair.image2];
  matched.matches = WithoutRepeats(MatchMutually(first.descriptors, second.descriptors), first, second);
  TwoViewExample& example = matched.example;
  example.image1 = source_.images[pair.image1].name;
  example.image2 = source_.images[pair.image2].name;
  example.id = example.image1 + "-" + example.image2;
  FillProblem(pair, &matched);
  FillTruth(pair, &example);
  const Eigen::VectorXd distances = TruthDistances(example.problem, example.truth);
  matched.kept = options_.min_true_matches == 0 ||
                 (distances.array() <= options_.true_match_px).count() >= options_.min_true_matches;
  return matched;
}

DescriptorMatrix Preparation::DescriptorsOf(const SourcePair& pair, const std::vector<DescriptorMatch>& matches) const {
  const DescriptorMatrix &first = features_[pair.image1].descriptors, &second = features_[pair.image2].descriptors;
  DescriptorMatrix rows(static_cast<Eigen::Index>(matches.size()), first.cols() + second.cols());
  for (std::size_t i = 0; i < matches.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) << first.row(matches[i].first), second.row(matches[i].second);
  return rows;
}

CorrespondenceSet Preparation::Collect(const SourceScene& scene, std::vector<MatchedPair>* matched,
                                       std::vector<std::size_t>* kept) const {
  CorrespondenceSet set;
  for (std::size_t i = 0; i < matched->size(); ++i) {
    if (!(*matched)[i].kept) continue;
    kept->push_back(i);
    set.pairs.push_back(std::move((*matched)[i].example));
    for (int image : {scene.pairs[i].image1, scene.pairs[i].image2})
      if (source_.images[image].pose) set.cameras[source_.images[image].name] = *source_.images[image].pose;
  }
  return set;
}

bool Preparation::WriteScene(const SourceScene& scene) {
  std::vector<MatchedPair> matched(scene.pairs.size());
  {
    Progress progress(scene.name, static_cast<std::int64_t>(scene.pairs.size()));
    ParallelFor(static_cast<std::int64_t>(scene.pairs.size()), options_.threads, [&](std::int64_t i) {
      if (stop_) return;
      matched[i] = MatchPair(scene.pairs[i]);
      progress.Advance();
    });
  }
  if (stop_) return false;
  std::vector<std::size_t> kept;
  CorrespondenceSet set = Collect(scene, &matched, &kept);
  if (kept.empty()) throw Error(scene.name + ": no pair has enough true matches");
  if (options_.descriptors)
    set.descriptors = [&](std::size_t i) { return DescriptorsOf(scene.pairs[kept[i]], matched[kept[i]].matches); };
  const std::string folder = (fs::path(output_) / scene.name).string();
  WriteCorrespondences(folder, set);
  LogInfo(folder + ": " + std::to_string(kept.size()) + " of " + std::to_string(scene.pairs.size()) + " pairs");
  return true;
}

bool Preparation::Run() {
  std::vector<SourceScene> scenes = source_.scenes;
  for (SourceScene& scene : scenes) scene.pairs = EvenlySpaced(scene.pairs, options_.max_pairs);
  if (!ExtractAll(scenes)) return false;
  for (const SourceScene& scene : scenes)
    if (!WriteScene(scene)) return false;
  return true;
}

ImageSource ReadSource(const PairsRequest& request) {
  if (request.format == "kitti") {
    if (request.sequence.empty()) throw Error("--sequence is needed for KITTI (00, 01, ...)");
    return ReadKitti(request.input, request.sequence, request.steps);
  }
  if (request.format == "strecha") return ReadStrecha(request.input);
  if (request.format == "colmap") return ReadColmap(request.input);
  if (request.format == "homographies") return ReadHomographies(request.input);
  if (request.format == "images") return ReadImageFolder(request.input, request.calibration);
  throw Error("unknown format '" + request.format + "'");
}

// The two sets of correspondences that come with the images: nothing is matched.
bool RunAdelaideRmf(const PairsRequest& request, const std::atomic<bool>& stop) {
  const std::string name = request.scene.empty() ? "adelaidermf" : request.scene;
  for (const auto& [kind, scene] : {std::pair(AdelaideCorrespondences::kLabelled, name),
                                    std::pair(AdelaideCorrespondences::kTentative, name + "_sift")}) {
    if (kind == AdelaideCorrespondences::kTentative && !fs::exists(fs::path(request.input) / "sift_update")) break;
    const CorrespondenceSet set = ReadAdelaideRmf(request.input, kind);
    if (stop) return false;
    const std::string folder = (fs::path(request.output) / scene).string();
    WriteCorrespondences(folder, set);
    LogInfo(folder + ": " + std::to_string(set.pairs.size()) + " pairs");
  }
  return true;
}

}  // namespace

void PrepareOptions::Check() const {
  features.Check();
  if (max_pairs < 0 || min_true_matches < 0 || threads < 0)
    throw Error("max_pairs, min_true_matches and threads must not be negative");
  if (!(true_match_px > 0.0)) throw Error("true_match_px must be positive");
}

bool PreparePairs(const ImageSource& source, const PrepareOptions& options, const std::string& output,
                  const std::atomic<bool>& stop) {
  options.Check();
  // Before minutes of work.
  MakeWritableFolder(output);
  return Preparation(source, options, output, stop).Run();
}

bool RunPairs(const PairsRequest& request, const std::atomic<bool>& stop) {
  if (request.format == "adelaidermf") return RunAdelaideRmf(request, stop);
  ImageSource source = ReadSource(request);
  if (!request.scene.empty()) {
    if (source.scenes.size() != 1)
      throw Error("--scene: the source has " + std::to_string(source.scenes.size()) + " scenes");
    source.scenes[0].name = request.scene;
  }
  return PreparePairs(source, request.options, request.output, stop);
}

}  // namespace diffsac
