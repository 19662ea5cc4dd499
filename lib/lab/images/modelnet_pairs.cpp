#include "lab/images/modelnet_pairs.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <set>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/config/progress.h"
#include "lab/data/modelnet.h"
#include "lab/files/correspondence_files.h"
#include "lab/files/files.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

ModelnetOptions OptionsOf(const ModelnetRequest& request) {
  if (request.pairs < 1 || request.points < 1 || request.seed < 0 || request.threads < 0)
    throw Error("--pairs and --points must be positive, --seed and --threads not negative");
  const std::vector<double>& ratio = request.outlier_ratio;
  const bool ordered = !ratio.empty() && ratio.size() <= 2 && ratio.front() <= ratio.back();
  if (!ordered || !(ratio.front() >= 0.0) || !(ratio.back() < 1.0))
    throw Error("--outlier-ratio: expected R or LOW,HIGH in [0, 1)");
  std::error_code code;
  if (!fs::exists(request.input, code)) throw Error(request.input + ": no such file or folder");
  ModelnetOptions options;
  options.paths = {request.input};
  options.subset = request.subset;
  options.size = request.pairs;
  options.matches.num_points = request.points;
  options.matches.outlier_ratio = Range(ratio.front(), ratio.back());
  return options;
}

// "modelnet40/12/chair_0001" to "000012_chair_0001".
std::string ImagePrefix(const Example& example) {
  char number[24];
  std::snprintf(number, sizeof(number), "%06lld_", static_cast<long long>(example.index));
  std::string mesh = fs::path(example.id).filename().string();
  std::replace(mesh.begin(), mesh.end(), '-', '_');
  return number + mesh;
}

// Named and with the truth that the files hold.
Example AsImagePair(Example example) {
  const std::string prefix = ImagePrefix(example);
  example.image1 = prefix + "_1";
  example.image2 = prefix + "_2";
  example.id = example.image1 + "-" + example.image2;
  GroundTruth& truth = example.truth;
  truth.motion = RigidMotion{truth.pose.value().rotation, truth.pose.value().translation};
  truth.assignment.assign(truth.inliers.begin(), truth.inliers.end());
  CompleteTruth(example.problem, &truth);
  return example;
}

// The first camera is the world.
CorrespondenceSet Collect(std::vector<Example> pairs, const std::vector<std::string>& problems) {
  CorrespondenceSet set;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!problems[i].empty()) continue;
    set.cameras[pairs[i].image1] = {};
    set.cameras[pairs[i].image2] = *pairs[i].truth.motion;
    set.pairs.push_back(std::move(pairs[i]));
  }
  return set;
}

}  // namespace

PrepareResult WriteModelnetPairs(const ModelnetRequest& request, const std::atomic<bool>& stop) {
  const ModelnetOptions options = OptionsOf(request);
  const std::string folder = (fs::path(request.output) / request.scene).string();
  PrepareResult result;
  std::error_code code;
  if (!request.overwrite && fs::exists(fs::path(folder) / "matches.h5", code)) {
    LogInfo(folder + ": already there; --overwrite makes it again");
    result.already_there = 1;
    return result;
  }
  const auto dataset = MakeModelnet(options, static_cast<std::uint64_t>(request.seed));
  MakeWritableFolder(request.output);
  std::vector<Example> pairs(static_cast<std::size_t>(request.pairs));
  std::vector<std::string> problems(pairs.size());
  {
    Progress progress(request.scene, request.pairs);
    ParallelFor(request.pairs, request.threads, [&](std::int64_t i) {
      if (stop) return;
      try {
        pairs[i] = AsImagePair(dataset->Get(static_cast<std::uint64_t>(i)));
      } catch (const Error& error) {
        problems[i] = error.what();
      }
      progress.Advance();
    });
  }
  result.finished = !stop;
  if (stop) return result;
  const std::set<std::string> different(problems.begin(), problems.end());
  for (const std::string& problem : different)
    if (!problem.empty()) result.left_out.push_back(problem);
  for (const std::string& problem : result.left_out) LogWarning("left out: " + problem);
  const CorrespondenceSet set = Collect(std::move(pairs), problems);
  if (set.pairs.empty()) throw Error(request.input + ": no pairs; " + result.left_out.at(0));
  WriteCorrespondences(folder, set);
  LogInfo(folder + ": " + std::to_string(set.pairs.size()) + " of " + std::to_string(request.pairs) + " pairs");
  result.written = 1;
  return result;
}

}  // namespace diffsac
