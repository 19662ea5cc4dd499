// Trains a learned method from a YAML configuration. See docs/configuration.md.
#include <CLI/CLI.hpp>

#include <atomic>
#include <csignal>
#include <iostream>

#include "diffsac/core/files.h"
#include "diffsac/core/memory.h"
#include "diffsac/core/passive_waiting.h"
#include "diffsac/core/resources.h"
#include "diffsac/core/status.h"
#include "diffsac/distributed/process_group.h"
#include "diffsac/estimators/diffsac_engine.h"
#include "diffsac/lab/run_directory.h"
#include "diffsac/lab/terminal_log.h"
#include "diffsac/lab/yaml.h"
#include "diffsac/train/configuration_reference.h"
#include "diffsac/train/import_network.h"
#include "diffsac/train/trainer.h"
#include "diffsac/train/training_folder.h"

namespace {

std::atomic<bool> stop_requested{false};

void RequestStop(int) { stop_requested = true; }

constexpr int kBadInput = 2;

struct CommandLine {
  std::string config_path, output, weights, device = "auto";
  std::vector<std::string> assignments;
  bool resume = false, overwrite = false;
  int threads = 0;
  std::int64_t seed = -1;
  double timeout_s = diffsac::kGroupTimeoutSeconds;
};

void AddOptions(CLI::App* app, CommandLine* line) {
  app->set_version_flag("--version", diffsac::VersionText("diffsac_train"));
  app->add_option("--config", line->config_path, "Configuration (YAML); with --resume: the run folder's unless given");
  app->add_flag_callback(
      "--describe-options",
      [] {
        std::cout << diffsac::ConfigurationReference();
        throw CLI::Success();
      },
      "Print every key of the configurations in Markdown (docs/configuration.md)");
  app->add_option("--set", line->assignments, "key.path=value, overrides the configuration")->allow_extra_args(false);
  app->add_option("--output", line->output, "Run folder (default: runs/<name>)");
  auto* resume = app->add_flag("--resume", line->resume, "Continue from the run folder's last checkpoint");
  app->add_flag("--overwrite", line->overwrite, "Start anew where the run folder holds a training")->excludes(resume);
  app->add_option("--import", line->weights, "Take the weights of a safetensors file (scripts/peers/), do not train")
      ->excludes(resume);
  app->add_option("--device", line->device, "auto, cpu, cuda or cuda:INDEX");
  app->add_option("--threads", line->threads, "Threads (0: all cores)")->check(CLI::Range(0, 1024));
  app->add_option("--seed", line->seed, "Replaces train.seed")->check(CLI::NonNegativeNumber);
  app->add_option("--group-timeout", line->timeout_s, "Seconds that processes wait for each other")
      ->check(CLI::PositiveNumber);
}

diffsac::TrainRequest ReadRequest(const CommandLine& line) {
  auto config = line.config_path.empty() ? diffsac::ConfigurationToResume(line.output)
                                         : diffsac::ConfigFromFile(line.config_path);
  for (const auto& assignment : line.assignments) SetYaml(&config, assignment);
  if (line.seed >= 0) SetYaml(&config, "train.seed=" + std::to_string(line.seed));
  // What neither an import nor a training that goes on reads need not be there.
  if (line.weights.empty() && !line.resume) diffsac::RequirePaths(config, {"train.start_from"}, "checkpoint");
  diffsac::TrainRequest request(config);
  request.output = line.output.empty() ? "runs/" + request.options.name : line.output;
  request.resume = line.resume;
  request.overwrite = line.overwrite;
  request.device = line.device;
  request.threads = line.threads;
  return request;
}

int Run(const CommandLine& line) {
  diffsac::CheckDevice(line.device);
  diffsac::TrainRequest request = ReadRequest(line);
  if (!line.weights.empty()) {
    diffsac::ImportNetwork(request, line.weights);
    return 0;
  }
  const auto group = diffsac::JoinProcessGroup(line.timeout_s);
  request.group = group.get();
  const bool main_process = !group || group->main();
  diffsac::CheckStart(request);  // Before there is a log in the folder.
  if (main_process) diffsac::MakeWritableFolder(request.output);
  diffsac::InitLogging(main_process ? request.output + "/log.txt" : "", !main_process);
  return diffsac::Train(request, stop_requested) == diffsac::TrainOutcome::kFinished ? 0 : 130;
}

}  // namespace

int main(int argc, char** argv) {
  diffsac::WaitPassively(argv);
  diffsac::KeepFreedMemory();
  CLI::App app{"Trains DiffSAC and other learned methods"};
  CommandLine line;
  AddOptions(&app, &line);
  try {
    app.parse(argc, argv);
    if (line.config_path.empty() && !(line.resume && !line.output.empty()))
      throw CLI::RequiredError("--config, or --resume with --output,");
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::cerr << "diffsac_train: " << error.what() << std::endl;
    return kBadInput;
  }
  std::signal(SIGINT, RequestStop);
  std::signal(SIGTERM, RequestStop);
  try {
    return Run(line);
  } catch (const std::exception& error) {
    std::cerr << "diffsac_train: " << diffsac::MessageOf(error) << std::endl;
    return kBadInput;
  }
}
