#include "lab/eval/selection.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>
#include <utility>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
#include "lab/config/process.h"
#include "lab/config/yaml.h"
#include "lab/files/text_scan.h"
#include "lab/options/config.h"
#include "lab/options/config_tree.h"

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
  const Config config = ConfigFromFile(path);
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

void CollectRunPaths(const ConfigTree& tree, std::vector<std::string>* paths) {
  if (tree.scalar.starts_with("runs/") && std::find(paths->begin(), paths->end(), tree.scalar) == paths->end())
    paths->push_back(tree.scalar);
  for (const ConfigTree& item : tree.items) CollectRunPaths(item, paths);
  for (const ConfigEntry& entry : tree.entries) CollectRunPaths(entry.value, paths);
}

/// Whether the training that writes this checkpoint has further to go: its best network so far is there early.
bool IsUnfinished(const std::string& checkpoint) {
  const fs::path last = fs::path(checkpoint).parent_path() / "last.safetensors";
  if (!fs::exists(last)) return false;
  const CheckpointInfo info = ReadCheckpointInfo(last.string());
  const Config config = CheckpointConfig(info, last.string());
  if (!config.Has("train.iterations")) return false;
  double iterations = 0.0;
  if (!ParseNumber(config.Text("train.iterations"), &iterations))
    throw Error(config.Where("train.iterations") + ": expected a number");
  return static_cast<double>(info.iteration) < iterations;
}

/// The exit code of a program, its output in a file. `stop` is passed on.
int RunProgram(const std::vector<std::string>& command, const std::string& log, const std::atomic<bool>& stop) {
  const int output = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  // It stops by itself, as at Ctrl-C, when this process is killed: nobody would wait for it any more.
  const int process = output < 0 ? -1 : StartProgram(command, output, SIGTERM);
  if (output >= 0) ::close(output);
  if (process < 0) return kCannotRun;
  siginfo_t state{};
  for (bool asked = false; state.si_pid == 0;) {
    if (::waitid(P_PID, static_cast<id_t>(process), &state, WEXITED | WNOHANG | WNOWAIT) != 0 && errno != EINTR) break;
    if (stop && !std::exchange(asked, true)) ::kill(process, SIGTERM);
    if (state.si_pid == 0) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return EndOfProgram(process);
}

}  // namespace

std::vector<MissingNetwork> MissingNetworks(const ExperimentOptions& experiment, const std::string& configs) {
  std::vector<MissingNetwork> networks;
  for (const std::string& checkpoint : RowFiles(experiment)) {
    const std::string name = RunOf(checkpoint);
    if (name.empty() || (fs::exists(checkpoint) && !IsUnfinished(checkpoint))) continue;
    networks.push_back({name, checkpoint, TrainingOf(name, configs)});
    const std::size_t seed = name.rfind(kTrainingSeed);
    if (!networks.back().config.empty() || seed == std::string::npos) continue;
    networks.back().config = TrainingOf(name.substr(0, seed), configs);
    networks.back().seed = name.substr(seed + kTrainingSeed.size());
  }
  return networks;
}

std::vector<std::string> NeededFolders(const ExperimentOptions& experiment, bool trained, const std::string& configs) {
  std::vector<std::string> folders = DataPaths(experiment);
  if (!trained) return folders;
  for (const MissingNetwork& network : MissingNetworks(experiment, configs))
    if (!network.config.empty()) CollectRunPaths(*ConfigFromFile(network.config).impl_->Get(), &folders);
  return folders;
}

namespace {

fs::path RunOf(const MissingNetwork& network) { return fs::path(network.checkpoint).parent_path().parent_path(); }

}  // namespace

std::vector<std::string> TrainingCommand(const MissingNetwork& network, const std::string& device) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "diffsac_train", run = RunOf(network);
  std::vector<std::string> command = {program.string(), "--config", network.config, "--output",
                                      run.string(),     "--device", device};
  if (!network.seed.empty()) command.insert(command.end(), {"--set", "train.seed=" + network.seed});
  if (fs::exists(run / "checkpoints" / "last.safetensors")) command.push_back("--resume");
  return command;
}

bool TrainNetworks(const std::vector<MissingNetwork>& networks, const std::string& device,
                   const std::atomic<bool>& stop) {
  for (const MissingNetwork& network : networks) {
    if (network.config.empty()) {
      LogWarning("no training configuration is named '" + network.name + "', for " + network.checkpoint);
      continue;
    }
    const fs::path run = RunOf(network);
    fs::create_directories(run);
    const std::string log = run.string() + ".log";
    LogInfo("training " + network.config + ", log in " + log);
    const int code = RunProgram(TrainingCommand(network, device), log, stop);
    if (code == kInterrupted) return false;
    if (code != 0) LogWarning(network.name + " was not trained: see " + log);
  }
  return true;
}

}  // namespace diffsac
