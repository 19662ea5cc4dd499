// Runs the methods of an experiment on its data and prints the table. See docs/metrics.md.
#include <ATen/Parallel.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <optional>

#include "diffsac/estimate/diffsac_estimator.h"
#include "lab/config/paths.h"
#include "lab/config/process.h"
#include "lab/config/program.h"
#include "lab/config/progress.h"
#include "lab/config/run_directory.h"
#include "lab/eval/evaluate.h"

namespace {

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

constexpr const char* kExamples = R"(
Examples:
  diffsac_eval --config configs/tables/line.yaml --limit 200
  diffsac_eval --config points.yaml --output runs/scan        your own points: docs/points.md
  diffsac_eval --config configs/tables/line.yaml --methods diffsac,ransac_1000 --set seed=2
  diffsac_eval --config configs/tables/line.yaml --checkpoint runs/my_line/checkpoints/best.safetensors
  python3 scripts/report runs/line                            report.html, tables and pictures of a run
  python3 scripts/report/compare.py runs/a runs/b

The run's folder gets problems.csv (a line a problem and method), estimates.h5 and run.json (what was run, on what).
Documentation: README.md; docs/configuration.md has every key of a configuration, docs/report.md explains the folder
and the report, docs/metrics.md the numbers, docs/estimates.md the estimates.
)";

/// What to run, and on what.
void AddRunOptions(CLI::App* app, diffsac::EvalRequest* request) {
  app->add_option("--config", request->config_path,
                  "Experiment (YAML), also by its name under share/diffsac/configs/tables");
  app->add_option("--set", request->assignments, "key.path=value, overrides the configuration; as often as wanted")
      ->allow_extra_args(false);
  app->add_option("--data", request->data_root,
                  "Folder of data sets, ${data_root} in the configuration (default: the configuration's)")
      ->check(CLI::ExistingDirectory);
  app->add_flag("--train-missing", request->train_missing,
                "Trains networks under runs/ that rows name and that are missing");
  app->add_flag("--rows", request->rows, "Only prints the rows, by their labels");
  app->add_flag("--needs", request->needs,
                "Only prints which folders the rows read, with --train-missing also those of trainings");
  app->add_option("--checkpoint", request->context.checkpoint_override,
                  "Replaces the checkpoint of the rows of its method (default: the rows' own)");
  app->add_option("--methods", request->methods, "Only these rows: a,b,... (default: all)")->delimiter(',');
  app->add_option("--limit", request->limit, "At most so many problems a condition (default: the configuration's)")
      ->default_str("")
      ->check(diffsac::NumberAbove(0));
  app->add_option("--seed", request->seed, "Replaces the experiment's seed (default: the configuration's)")
      ->default_str("")
      ->check(diffsac::NumberFrom(0));
  app->add_option("--device", request->context.device, "auto, cpu, cuda or cuda:INDEX");
  app->add_option("--threads", request->context.threads, "Threads (0: as configured, else all cores)")
      ->check(diffsac::NumberWithin(0, 1024));
}

/// Where results go.
void AddOutputOptions(CLI::App* app, diffsac::EvalRequest* request) {
  app->add_option("--output", request->output, "Run folder (default: runs/NAME, the experiment's name)");
  app->add_option("--shard", request->shard,
                  "i/n: only this part of the problems; scripts/report/merge.py joins the n folders");
  auto* update =
      app->add_flag("--update", request->update, "Nothing is done where the run folder holds these results already");
  auto* database =
      app->add_option("--export-colmap", request->colmap.database, "COLMAP database that gets the verified matches");
  app->add_flag("--export-overwrite", request->colmap.overwrite, "Replaces two-view geometries that it has")
      ->needs(database);
  app->add_flag("--export-chance", request->colmap.chance,
                "Also pairs with no more inliers than unlike images would give")
      ->needs(database);
  update->excludes(database);
}

int Run(const CLI::App& app, diffsac::EvalRequest request) {
  if (request.config_path.empty()) throw CLI::RequiredError("--config");
  request.config_path = diffsac::NamedConfiguration(request.config_path, "configs/tables");
  if (app.count("--device") > 0) request.training_device = request.context.device;
  if (request.context.threads > 0) at::set_num_threads(request.context.threads);
  diffsac::StopOnSignals();
  diffsac::InitLogging();
  return diffsac::Evaluate(request, Trace, diffsac::stop_requested, std::cout);
}

}  // namespace

int main(int argc, char** argv) {
  diffsac::WaitPassively(argv);
  diffsac::KeepFreedMemory();
  CLI::App app{"Runs the methods of an experiment on its data, prints the table and keeps every problem"};
  app.option_defaults()->always_capture_default();
  app.footer(std::string(kExamples) + diffsac::kExitCodesHelp);
  diffsac::EvalRequest request;
  app.set_version_flag("--version", diffsac::VersionText("diffsac_eval"));
  AddRunOptions(&app, &request);
  AddOutputOptions(&app, &request);
  return diffsac::RunProgram("diffsac_eval", &app, argc, argv, [&] { return Run(app, request); });
}
