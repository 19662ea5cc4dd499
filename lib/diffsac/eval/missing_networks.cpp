#include "diffsac/eval/missing_networks.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/core/yaml_tree.h"
#include "diffsac/eval/selection.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr int kInterrupted = 130;  // The exit code of a training that was stopped.

/// NAME of runs/NAME/checkpoints/FILE; empty for other paths.
std::string RunOf(const std::string& checkpoint) {
  const fs::path folder = fs::path(checkpoint).parent_path();
  const bool in_run = folder.filename() == "checkpoints" && folder.parent_path().parent_path() == "runs";
  return in_run ? folder.parent_path().filename().string() : "";
}

/// Experiments have names as well, but no `train`.
bool IsTrainingOf(const std::string& name, const std::string& path) {
  const Config config = Config::FromFile(path);
  return config.Has("train") && config.Has("name") && config.Text("name") == name;
}

std::string TrainingOf(const std::string& name, const std::string& configs) {
  std::vector<std::string> paths;
  std::error_code none;
  for (const auto& entry : fs::recursive_directory_iterator(configs, none))
    if (entry.path().extension() == ".yaml") paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  const auto found =
      std::find_if(paths.begin(), paths.end(), [&](const auto& path) { return IsTrainingOf(name, path); });
  return found == paths.end() ? "" : *found;
}

void CollectRunPaths(const YamlTree& tree, std::vector<std::string>* paths) {
  if (tree.scalar.starts_with("runs/") && std::find(paths->begin(), paths->end(), tree.scalar) == paths->end())
    paths->push_back(tree.scalar);
  for (const YamlTree& item : tree.items) CollectRunPaths(item, paths);
  for (const YamlEntry& entry : tree.entries) CollectRunPaths(entry.value, paths);
}

/// The exit code of a program that runs in its own process, its output in a file; -1 when it did not start or end well.
int RunProgram(const std::vector<std::string>& command, const std::string& log) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  ::posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t process = 0;
  const int failed = ::posix_spawn(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  if (failed != 0) return -1;
  // A terminal's Ctrl-C reaches both processes: the training stops by itself and says so.
  while (::waitpid(process, &status, 0) < 0)
    if (errno != EINTR) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

std::vector<MissingNetwork> MissingNetworks(const ExperimentOptions& experiment, const std::string& configs) {
  std::vector<MissingNetwork> networks;
  for (const std::string& checkpoint : MissingCheckpoints(experiment)) {
    const std::string name = RunOf(checkpoint);
    if (!name.empty()) networks.push_back({name, checkpoint, TrainingOf(name, configs)});
  }
  return networks;
}

std::vector<std::string> NeededFolders(const ExperimentOptions& experiment, const std::string& configs) {
  std::vector<std::string> folders = DataPaths(experiment);
  for (const MissingNetwork& network : MissingNetworks(experiment, configs))
    if (!network.config.empty()) CollectRunPaths(*Config::FromFile(network.config).impl_->Get(), &folders);
  return folders;
}

namespace {

fs::path RunOf(const MissingNetwork& network) { return fs::path(network.checkpoint).parent_path().parent_path(); }

}  // namespace

std::vector<std::string> TrainingCommand(const MissingNetwork& network, const std::string& device) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "diffsac_train", run = RunOf(network);
  std::vector<std::string> command = {program.string(), "--config", network.config, "--output",
                                      run.string(),     "--device", device};
  if (fs::exists(run / "checkpoints" / "last.safetensors")) command.push_back("--resume");
  return command;
}

bool TrainNetworks(const std::vector<MissingNetwork>& networks, const std::string& device) {
  for (const MissingNetwork& network : networks) {
    if (network.config.empty()) {
      LogWarning("no training configuration is named '" + network.name + "', for " + network.checkpoint);
      continue;
    }
    const fs::path run = RunOf(network);
    fs::create_directories(run);
    const std::string log = run.string() + ".log";
    LogInfo("training " + network.config + ", log in " + log);
    const int code = RunProgram(TrainingCommand(network, device), log);
    if (code == kInterrupted) return false;
    if (code != 0) LogWarning(network.name + " was not trained: see " + log);
  }
  return true;
}

}  // namespace diffsac
