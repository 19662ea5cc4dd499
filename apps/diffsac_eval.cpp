// Runs the methods of an experiment on its data and prints the table. See docs/metrics.md.
#include <ATen/Parallel.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <iostream>
#include <optional>

#include "diffsac/core/memory.h"
#include "diffsac/core/passive_waiting.h"
#include "diffsac/core/status.h"
#include "diffsac/distributed/process_group.h"
#include "diffsac/estimators/diffsac_estimator.h"
#include "diffsac/lab/run_directory.h"
#include "diffsac/lab/terminal_log.h"
#include "diffsac/report/command_line.h"

namespace {

std::atomic<bool> stop_requested{false};

void RequestStop(int) { stop_requested = true; }

/// The first copy's confidences of a diffusion method.
std::optional<diffsac::ConfidenceTrace> Trace(const diffsac::RobustEstimator& method, const diffsac::Problem& problem,
                                              std::uint64_t seed) {
  const auto* diffusion = dynamic_cast<const diffsac::DiffsacEstimator*>(&method);
  const auto steps = diffusion != nullptr ? diffusion->Trace(problem, seed) : std::nullopt;
  if (!steps) return std::nullopt;
  diffsac::ConfidenceTrace trace{steps->timesteps, {}};
  for (const auto& copies : steps->confidences)
    trace.confidence.emplace_back(copies.begin(), copies.begin() + problem.points.rows());
  return trace;
}

/// What a page says that it was written by.
std::string CommandOf(const diffsac::EvalRequest& request) {
  if (request.effects.empty()) return "diffsac_eval --config " + request.config_path;
  std::string command = "diffsac_eval --effects";
  for (const std::string& run : request.effects) command += " " + run;
  return command;
}

}  // namespace

int main(int argc, char** argv) {
  diffsac::WaitPassively(argv);
  diffsac::KeepFreedMemory();
  CLI::App app{"Evaluates robust estimators and prints a table"};
  diffsac::EvalRequest request;
  double timeout_s = diffsac::kGroupTimeoutSeconds;
  app.set_version_flag("--version", diffsac::VersionText("diffsac_eval"));
  app.add_option("--config", request.config_path, "Experiment (YAML, see configs/tables)");
  app.add_option("--set", request.assignments, "key.path=value, overrides the configuration")->allow_extra_args(false);
  app.add_option("--data", request.data_root, "Folder of data sets, ${data_root} in the configuration")
      ->check(CLI::ExistingDirectory);
  app.add_flag("--train-missing", request.train_missing,
               "Trains networks under runs/ that rows name and that are missing");
  app.add_flag("--needs", request.needs, "Only prints which folders the rows and missing networks read");
  app.add_option("--checkpoint", request.context.checkpoint_override,
                 "Replaces the checkpoint of the rows of its method");
  app.add_option("--methods", request.methods, "Only these rows: a,b,...")->delimiter(',');
  app.add_option("--limit", request.limit, "At most so many problems a condition")->check(CLI::PositiveNumber);
  app.add_option("--output", request.output, "Run folder (default: runs/<name>)");
  auto* update =
      app.add_flag("--update", request.update, "Nothing is done where the run folder holds these results already");
  auto* page = app.add_option("--page", request.page, "Also a page with tables and pictures (docs/results/NAME.md)");
  app.add_option("--page-command", request.page_command, "What the page says that it was written by")->needs(page);
  auto* database =
      app.add_option("--export-colmap", request.colmap.database, "COLMAP database that gets the verified matches");
  app.add_flag("--export-overwrite", request.colmap.overwrite, "Replaces two-view geometries that it has")
      ->needs(database);
  app.add_flag("--export-chance", request.colmap.chance,
               "Also pairs with no more inliers than unlike images would give")
      ->needs(database);
  update->excludes(database);
  app.add_option("--device", request.context.device, "auto, cpu, cuda or cuda:INDEX");
  app.add_option("--threads", request.context.threads, "Threads (0: all cores)")->check(CLI::Range(0, 1024));
  app.add_option("--seed", request.seed, "Replaces the experiment's seed")->check(CLI::NonNegativeNumber);
  app.add_option("--shard", request.shard, "i/n: only this part of the problems; join all n with --merge");
  app.add_option("--group-timeout", timeout_s, "Seconds that processes wait for each other")
      ->check(CLI::PositiveNumber);
  auto* merge = app.add_option("--merge", request.merge, "Joins the folders of all shards into --output");
  auto* compare =
      app.add_option("--compare", request.compare, "RUN_A RUN_B: what two run folders differ in")->expected(2);
  auto* effects = app.add_option("--effects", request.effects,
                                 "RUN...: what the factors of these run folders decide, on one --page");
  for (auto* alone : {merge, compare})
    for (auto* option : app.get_options({}))
      if (option != alone && !option->check_name("--output")) alone->excludes(option);
  for (auto* option : app.get_options({}))
    if (option != effects && !option->get_name().starts_with("--page")) effects->excludes(option);
  try {
    app.parse(argc, argv);
    if (request.merge.empty() && request.compare.empty() && request.effects.empty() && request.config_path.empty())
      throw CLI::RequiredError("--config");
    if (request.page_command.empty()) request.page_command = CommandOf(request);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::cerr << "diffsac_eval: " << error.what() << std::endl;
    return diffsac::kExitBadInput;
  }
  if (app.count("--device") > 0) request.training_device = request.context.device;
  if (request.context.threads > 0) at::set_num_threads(request.context.threads);
  std::signal(SIGINT, RequestStop);
  std::signal(SIGTERM, RequestStop);
  try {
    const auto group = diffsac::JoinProcessGroup(timeout_s);
    if (group) {
      request.group = diffsac::WorkGroup{group->rank(), group->size(), diffsac::DefaultThreads(group->place()),
                                         [&](const std::string& text) { return group->Gather(text); }};
      request.context.device = diffsac::LocalDevice(group->place(), request.context.device);
    }
    diffsac::InitLogging("", group && !group->main());
    return diffsac::Evaluate(request, Trace, stop_requested, std::cout);
  } catch (const std::exception& error) {
    std::cerr << "diffsac_eval: " << diffsac::MessageOf(error) << std::endl;
    return diffsac::kExitBadInput;
  }
}
