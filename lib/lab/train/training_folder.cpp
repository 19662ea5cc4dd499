#include "lab/train/training_folder.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
#include "lab/config/run_directory.h"
#include "lab/config/yaml.h"
#include "lab/files/files.h"
#include "lab/options/config.h"
#include "lab/torch/process_group.h"
#include "lab/train/metrics_log.h"
#include "lab/train/trainer.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProgram = "diffsac_train";
constexpr const char* kConfigFile = "config.yaml";
constexpr const char* kReport = "report.html";
constexpr const char* kIterations = "train.iterations";

/// What no step and no validation depends on.
constexpr std::array kFreeKeys = {"name", "train.log_every", "train.validate_every", "train.checkpoint_every",
                                  "train.workers"};

/// What a training leaves beside config.yaml and log.txt. The networks first: a process that is killed while it removes
/// them leaves none that would pass for the next training's.
constexpr std::array kLeft = {"checkpoints/best.safetensors",
                              "checkpoints/last.safetensors",
                              "metrics.csv",
                              "events.out.tfevents.diffsac",  // Of 0.2.
                              "training_curve.png",
                              "training_curve.gp",
                              kReport};

std::string CheckpointPath(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / "checkpoints" / name).string();
}
std::string LastCheckpoint(const std::string& folder) { return CheckpointPath(folder, "last.safetensors"); }

/// What stands in a folder, but hidden files: those are temporary, or of no program's.
std::vector<std::string> Listed(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code))
    if (const std::string name = entry->path().filename().string(); !name.starts_with('.')) names.push_back(name);
  if (code && fs::is_directory(folder)) throw Error("cannot read '" + folder.string() + "': " + code.message());
  std::sort(names.begin(), names.end());
  return names;
}

struct Content {
  std::vector<std::string> training;  ///< What a training has made.
  std::vector<std::string> others;    ///< What another program has made and a training would replace.
};

/// Without what a start that came to nothing leaves, and without files that no training touches.
Content ContentOf(const std::string& folder) {
  Content content;
  for (const std::string& name : Listed(fs::path(folder) / "checkpoints"))
    content.training.push_back("checkpoints/" + name);
  for (const std::string& name : Listed(folder)) {
    const bool left = std::find(kLeft.begin(), kLeft.end(), name) != kLeft.end();
    if (name == kReport || (name == kConfigFile && ProgramOfRun(folder) != kProgram))  // Every program writes both.
      content.others.push_back(name);
    else if (left || name.ends_with(".safetensors"))  // config.yaml says what network that is.
      content.training.push_back(name);
  }
  return content;
}

std::string Names(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(kMost, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() <= kMost ? text : text + " and " + std::to_string(names.size() - kMost) + " more";
}

void CheckUnused(const std::string& folder) {
  const Content content = ContentOf(folder);
  if (!content.training.empty())
    throw Error(folder + ": holds a training already (" + Names(content.training) +
                "): " + (fs::exists(LastCheckpoint(folder)) ? "--resume goes on with it, " : "") +
                "--overwrite starts anew in its place, another --output keeps it");
  if (content.others.empty()) return;
  const std::string program = ProgramOfRun(folder);
  throw Error(folder + ": holds files of " + (program.empty() || program == kProgram ? "another program" : program) +
              " (" + Names(content.others) + "): choose another --output; --overwrite trains there all the same");
}

std::string ChangeText(const ChangedKey& change) {
  constexpr const char* kAbsent = "none";
  return change.key + ": " + change.before.value_or(kAbsent) + ", now " + change.now.value_or(kAbsent);
}

std::string ChangeTexts(const std::vector<ChangedKey>& changes) {
  constexpr std::size_t kMost = 10;
  std::string text;
  for (std::size_t i = 0; i < std::min(kMost, changes.size()); ++i)
    text += (i > 0 ? "; " : "") + ChangeText(changes[i]);
  return changes.size() <= kMost ? text : text + "; and " + std::to_string(changes.size() - kMost) + " more";
}

/// As this program writes it: with the defaults of keys that the program which wrote the checkpoint did not have.
std::string ResolvedConfig(const CheckpointInfo& info, const std::string& path) {
  return WriteTrainConfig(ReadTrainConfig(CheckpointConfig(info, path)));
}

bool MayChange(const ChangedKey& change) {
  return change.key == kIterations || std::find(kFreeKeys.begin(), kFreeKeys.end(), change.key) != kFreeKeys.end();
}

CheckpointInfo InfoToResume(const std::string& folder) {
  const std::string path = LastCheckpoint(folder);
  if (!fs::exists(path))
    throw Error(path + ": no such checkpoint, so there is no training to resume; without --resume one starts");
  return ReadCheckpointInfo(path);
}

/// Throws Error unless the training in the folder can go on so; what changes, as a text.
std::string CheckResumed(const TrainRequest& request) {
  const std::string& folder = request.output;
  const CheckpointInfo info = InfoToResume(folder);
  const auto changes = ChangedKeys(ResolvedConfig(info, LastCheckpoint(folder)), WriteTrainConfig(request.options));
  std::vector<ChangedKey> refused;
  std::copy_if(changes.begin(), changes.end(), std::back_inserter(refused),
               [](const ChangedKey& change) { return !MayChange(change); });
  if (!refused.empty())
    throw Error(folder + ": its training has another configuration (" + ChangeTexts(refused) +
                "); --resume without --config goes on with its own, another --output trains with this one");
  for (const ChangedKey& change : changes)
    if (change.key == kIterations && request.options.train.iterations <= info.iteration)
      throw Error(folder + ": " + std::to_string(info.iteration) + " iterations are done (" + ChangeText(change) +
                  "); expected more than those");
  return ChangeTexts(changes);
}

std::string CheckedStart(const TrainRequest& request) {
  if (request.resume) return CheckResumed(request);
  const bool writes = request.group == nullptr || request.group->main();
  if (writes && !request.overwrite) CheckUnused(request.output);
  return "";
}

}  // namespace

Config ConfigurationToResume(const std::string& folder) {
  const CheckpointInfo info = InfoToResume(folder);
  const std::string path = (fs::path(folder) / kConfigFile).string(), program = ProgramOfRun(folder);
  // One without that line is the training's as well, edited by somebody.
  const bool own = fs::exists(path) && (program.empty() || program == kProgram);
  return own ? ConfigFromFile(path) : CheckpointConfig(info, LastCheckpoint(folder));
}

void CheckStart(const TrainRequest& request) { CheckedStart(request); }

TrainingFolder::TrainingFolder(const TrainRequest& request)
    : path_(request.output), overwrite_(request.overwrite), seed_(request.options.train.seed) {
  // Before anything is touched; and again when no other process can start there any more.
  changes_ = CheckedStart(request);
  if (request.group != nullptr && !request.group->main()) return;
  lock_.emplace(path_);
  changes_ = CheckedStart(request);
}

std::string TrainingFolder::Checkpoint(const std::string& name) const { return CheckpointPath(path_, name); }

void TrainingFolder::Begin(const std::string& resolved_config) {
  if (overwrite_)
    for (const char* name : kLeft) RemoveFile((fs::path(path_) / name).string());
  const RunDirectory directory(path_, kProgram, resolved_config, seed_);
  fs::create_directories(directory.File("checkpoints"));
}

}  // namespace diffsac
