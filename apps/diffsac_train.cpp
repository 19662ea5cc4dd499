// Trains a learned method from a YAML configuration. See docs/configuration.md.
#include <CLI/CLI.hpp>

#include <filesystem>
#include <iostream>

#include "diffsac/estimate/diffsac_model.h"
#include "lab/config/paths.h"
#include "lab/config/process.h"
#include "lab/config/program.h"
#include "lab/config/progress.h"
#include "lab/config/run_directory.h"
#include "lab/config/yaml.h"
#include "lab/files/files.h"
#include "lab/torch/process_group.h"
#include "lab/train/configuration_reference.h"
#include "lab/train/import_network.h"
#include "lab/train/trainer.h"
#include "lab/train/training_folder.h"

namespace {

constexpr const char* kExamples = R"(
Examples:
  diffsac_train --config configs/line.yaml --output runs/my_line
  diffsac_train --config configs/line.yaml --set train.iterations=8000 --set train.batch_size=32
  diffsac_train --resume --output runs/my_line
  diffsac_eval --config configs/tables/line.yaml --checkpoint runs/my_line/checkpoints/best.safetensors

The run's folder gets checkpoints/best.safetensors and last.safetensors, metrics.csv and report.html (it reloads
itself while the training runs). scripts/report/to_tensorboard.py makes TensorBoard's files of metrics.csv.
Documentation: README.md; docs/configuration.md has every key of a configuration, docs/report.md explains the report,
docs/reliability.md what a run's folder may hold.
)";

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
  app->add_option("--config", line->config_path,
                  "Configuration (YAML), also by its name under share/diffsac/configs; with --resume: the run folder's "
                  "unless given");
  app->add_flag_callback(
      "--describe-options",
      [] {
        std::cout << diffsac::ConfigurationReference();
        throw CLI::Success();
      },
      "Print every key of the configurations in Markdown (docs/configuration.md)");
  app->add_option("--set", line->assignments, "key.path=value, overrides the configuration; as often as wanted")
      ->allow_extra_args(false);
  app->add_option("--output", line->output, "Run folder (default: runs/NAME, the configuration's name)");
  auto* resume = app->add_flag("--resume", line->resume, "Continue from the run folder's last checkpoint");
  app->add_flag("--overwrite", line->overwrite, "Start anew where the run folder holds a training")->excludes(resume);
  app->add_option("--import", line->weights, "Take the weights of a safetensors file (scripts/peers/), do not train")
      ->excludes(resume);
  app->add_option("--device", line->device, "auto, cpu, cuda or cuda:INDEX");
  app->add_option("--threads", line->threads, "Threads (0: all cores)")->check(diffsac::NumberWithin(0, 1024));
  app->add_option("--seed", line->seed, "Replaces train.seed (default: the configuration's)")
      ->default_str("")
      ->check(diffsac::NumberFrom(0));
  app->add_option("--group-timeout", line->timeout_s, "Seconds that processes wait for each other")
      ->check(diffsac::NumberAbove(0));
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

/// An imported network has no report.
void SayResults(const std::string& folder) {
  std::cout << "results are in " << folder << ": ";
  if (std::filesystem::exists(folder + "/report.html")) std::cout << "report.html (open it in a browser), ";
  std::cout << "checkpoints/best.safetensors" << std::endl;
}

int Run(CommandLine line) {
  if (line.config_path.empty() && !(line.resume && !line.output.empty()))
    throw CLI::RequiredError("--config, or --resume with --output,");
  diffsac::StopOnSignals();
  diffsac::CheckDevice(line.device);
  if (!line.config_path.empty()) line.config_path = diffsac::NamedConfiguration(line.config_path, "configs");
  diffsac::TrainRequest request = ReadRequest(line);
  // A run's own configuration may be run again in its folder.
  std::vector<std::string> outputs;
  for (const char* name : {"log.txt", "metrics.csv", "report.html", "checkpoints/best.safetensors",
                           "checkpoints/last.safetensors", "config.yaml"})
    if (std::string(name) != "config.yaml" || diffsac::ProgramOfRun(request.output).empty())
      outputs.push_back(request.output + "/" + name);
  diffsac::RefuseInputsAsOutputs(outputs, {line.config_path, line.weights});
  if (!line.weights.empty()) {
    diffsac::ImportNetwork(request, line.weights);
    SayResults(request.output);
    return diffsac::kExitOk;
  }
  const auto group = diffsac::JoinProcessGroup(line.timeout_s);
  request.group = group.get();
  const bool main_process = !group || group->main();
  diffsac::CheckStart(request);  // Before there is a log in the folder.
  if (main_process) diffsac::MakeWritableFolder(request.output);
  diffsac::InitLogging(main_process ? request.output + "/log.txt" : "", !main_process);
  const auto outcome = diffsac::Train(request, diffsac::stop_requested);
  if (main_process) SayResults(request.output);
  return outcome == diffsac::TrainOutcome::kFinished ? diffsac::kExitOk : diffsac::kExitInterrupted;
}

}  // namespace

int main(int argc, char** argv) {
  diffsac::WaitPassively(argv);
  diffsac::KeepFreedMemory();
  CLI::App app{"Trains DiffSAC and other learned methods"};
  app.option_defaults()->always_capture_default();
  app.footer(std::string(kExamples) + diffsac::kExitCodesHelp);
  CommandLine line;
  AddOptions(&app, &line);
  return diffsac::RunProgram("diffsac_train", &app, argc, argv, [&] { return Run(line); });
}
