// Trains a learned method from a YAML configuration. See docs/configuration.md.
#include <CLI/CLI.hpp>

#include <atomic>
#include <csignal>
#include <iostream>

#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/memory.h"
#include "diffsac/core/passive_waiting.h"
#include "diffsac/core/resources.h"
#include "diffsac/core/run_directory.h"
#include "diffsac/core/status.h"
#include "diffsac/distributed/process_group.h"
#include "diffsac/methods/diffsac_engine.h"
#include "diffsac/train/configuration_reference.h"
#include "diffsac/train/import_network.h"
#include "diffsac/train/trainer.h"

namespace {

std::atomic<bool> stop_requested{false};

void RequestStop(int) { stop_requested = true; }

}  // namespace

int main(int argc, char** argv) {
  diffsac::WaitPassively(argv);
  diffsac::KeepFreedMemory();
  CLI::App app{"Trains DiffSAC and other learned methods"};
  std::string config_path, output, weights;
  std::vector<std::string> assignments;
  bool resume = false;
  std::string device = "auto";
  int threads = 0;
  std::int64_t seed = -1;
  double timeout_s = diffsac::kGroupTimeoutSeconds;
  app.set_version_flag("--version", diffsac::VersionText("diffsac_train"));
  app.add_option("--config", config_path, "Configuration (YAML)")->required();
  app.add_flag_callback(
      "--describe-options",
      [] {
        std::cout << diffsac::ConfigurationReference();
        throw CLI::Success();
      },
      "Print every key of the configurations in Markdown (docs/configuration.md)");
  app.add_option("--set", assignments, "key.path=value, overrides the configuration")->allow_extra_args(false);
  app.add_option("--output", output, "Run folder (default: runs/<name>)");
  app.add_flag("--resume", resume, "Continue from the run folder's last checkpoint");
  app.add_option("--import", weights, "Take the weights of a safetensors file (scripts/peers/), do not train")
      ->excludes("--resume");
  app.add_option("--device", device, "auto, cpu, cuda or cuda:INDEX");
  app.add_option("--threads", threads, "Threads (0: all cores)")->check(CLI::Range(0, 1024));
  app.add_option("--seed", seed, "Replaces train.seed")->check(CLI::NonNegativeNumber);
  app.add_option("--group-timeout", timeout_s, "Seconds that processes wait for each other")
      ->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  std::signal(SIGINT, RequestStop);
  std::signal(SIGTERM, RequestStop);
  try {
    diffsac::CheckDevice(device);
    auto config = diffsac::Config::FromFile(config_path);
    for (const auto& assignment : assignments) config.Set(assignment);
    if (seed >= 0) config.Set("train.seed=" + std::to_string(seed));
    diffsac::TrainRequest request(config);
    request.output = output.empty() ? "runs/" + request.options.name : output;
    request.resume = resume;
    request.device = device;
    request.threads = threads;
    if (!weights.empty()) {
      diffsac::ImportNetwork(request, weights);
      return 0;
    }
    diffsac::RequirePaths(config, {"train.start_from"}, "checkpoint");
    const auto group = diffsac::JoinProcessGroup(timeout_s);
    request.group = group.get();
    const bool main_process = !group || group->main();
    if (main_process) diffsac::MakeWritableFolder(request.output);
    diffsac::InitLogging(main_process ? request.output + "/log.txt" : "", !main_process);
    return diffsac::Train(request, stop_requested) == diffsac::TrainOutcome::kFinished ? 0 : 130;
  } catch (const std::exception& error) {
    std::cerr << "diffsac_train: " << diffsac::MessageOf(error) << std::endl;
    return 2;
  }
}
