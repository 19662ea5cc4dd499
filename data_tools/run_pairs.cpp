#include "data_tools/run_pairs.h"

#include <filesystem>
#include <set>

#include "data_tools/adelaide_rmf.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/data/correspondence_files.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// KITTI's reader knows its frames' numbers, so it takes the steps itself.
ImageSource ReadKittiPairs(const PairsRequest& request) {
  if (request.choice.every != 1) throw Error("--every: KITTI's pairs are chosen by --steps or --pairs-file");
  const std::vector<int>& steps = request.choice.steps;
  ImageSource source = ReadKitti(request.input, request.sequence, steps.empty() ? std::vector<int>{1} : steps);
  if (request.choice.pairs_file.empty()) return source;
  if (!steps.empty()) throw Error("--steps and --pairs-file exclude each other");
  source.scenes[0].name = "kitti_" + request.sequence;
  ChoosePairs(request.choice, request.input, &source);
  return source;
}

ImageSource ReadAllPairs(const PairsRequest& request) {
  if (request.format == "strecha") return ReadStrecha(request.input);
  if (request.format == "colmap") return ReadColmap(request.input);
  if (request.format == "nerf") return ReadNerf(request.input);
  if (request.format == "poses") return ReadPoses(request.input, request.calibration);
  if (request.format == "homographies") return ReadHomographies(request.input);
  return ReadImageFolder(request.input, request.calibration);
}

ImageSource ReadSource(const PairsRequest& request) {
  if (request.format == "kitti") {
    if (request.sequence.empty()) throw Error("--sequence is needed for KITTI (00, 01, ...)");
    return ReadKittiPairs(request);
  }
  ImageSource source = ReadAllPairs(request);
  ChoosePairs(request.choice, request.input, &source);
  return source;
}

// The two sets of correspondences that come with the images: nothing is matched.
PrepareResult RunAdelaideRmf(const PairsRequest& request, const std::atomic<bool>& stop) {
  PrepareResult result;
  const std::string name = request.scene.empty() ? "adelaidermf" : request.scene;
  for (const auto& [kind, scene] : {std::pair(AdelaideCorrespondences::kLabelled, name),
                                    std::pair(AdelaideCorrespondences::kTentative, name + "_sift")}) {
    if (kind == AdelaideCorrespondences::kTentative && !fs::exists(fs::path(request.input) / "sift_update")) break;
    const std::string folder = (fs::path(request.output) / scene).string();
    if (!request.options.overwrite && fs::exists(fs::path(folder) / "matches.h5")) {
      LogInfo(folder + ": already there");
      result.already_there += 1;
      continue;
    }
    const CorrespondenceSet set = ReadAdelaideRmf(request.input, kind);
    result.finished = !stop;
    if (stop) break;
    WriteCorrespondences(folder, set);
    LogInfo(folder + ": " + std::to_string(set.pairs.size()) + " pairs");
    result.written += 1;
  }
  return result;
}

// Options that the format would not look at are mistakes.
void CheckRequest(const PairsRequest& request) {
  static const std::set<std::string> kFormats = {"kitti", "strecha",      "colmap",      "nerf",
                                                 "poses", "homographies", "adelaidermf", "images"};
  if (kFormats.count(request.format) == 0) throw Error("unknown format '" + request.format + "'");
  const GivenCalibration& given = request.calibration;
  const bool has_calibration = !given.file.empty() || given.focal != 0.0 || !given.center.empty();
  if (has_calibration && request.format != "images" && request.format != "poses")
    throw Error("--calibration, --focal and --center are for images and poses; " + request.format + " has its own");
  if (!request.sequence.empty() && request.format != "kitti") throw Error("--sequence is for kitti");
  if (!request.choice.IsAll() && request.format == "adelaidermf")
    throw Error(request.input + ": the pairs of this format cannot be chosen");
}

}  // namespace

PrepareResult RunPairs(const PairsRequest& request, const std::atomic<bool>& stop) {
  CheckRequest(request);
  if (request.format == "adelaidermf") return RunAdelaideRmf(request, stop);
  ImageSource source = ReadSource(request);
  RequireMotion(request.min_motion, request.input, &source);
  if (!request.scene.empty()) {
    if (source.scenes.size() != 1)
      throw Error("--scene: the source has " + std::to_string(source.scenes.size()) + " scenes");
    source.scenes[0].name = request.scene;
  }
  return PreparePairs(source, request.options, request.output, stop);
}

}  // namespace diffsac
