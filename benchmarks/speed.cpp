// Speed of the estimators and of the denoiser on this machine, in milliseconds, Hz and ratios taken in one run: the
// variants of a table are run in turn, round after round, and each figure is the median over rounds, so that a machine
// whose speed drifts changes all of them alike.
//
//   diffsac_benchmark --checkpoint models/line/model.safetensors [--rounds 21] [--threads 1,2]
#include <torch/torch.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "diffsac/estimate/diffsac_estimator.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/make_estimator.h"
#include "lab/config/run_directory.h"
#include "lab/config/yaml.h"
#include "lab/data/synthetic.h"
#include "lab/torch/diffsac_network.h"
#include "measure.h"

namespace diffsac {
namespace {

struct Variant {
  std::string name;
  std::function<void()> run;
  double per_call = 1.0;  ///< units of work in one call (problems, steps, hypotheses)
};

// Ratios are against the first variant, pair by pair within a round.
void Table(const std::string& title, const std::vector<Variant>& variants, int rounds) {
  std::printf("\n### %s\n\n| variant | ms per unit | per second | time / first |\n|---|---|---|---|\n", title.c_str());
  std::vector<std::vector<double>> times(variants.size()), ratios(variants.size());
  for (const auto& variant : variants) variant.run();
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < variants.size(); ++i)
      times[i].push_back(Milliseconds(variants[i].run) / variants[i].per_call);
    for (std::size_t i = 0; i < variants.size(); ++i) ratios[i].push_back(times[i].back() / times[0].back());
  }
  for (std::size_t i = 0; i < variants.size(); ++i) {
    const double ms = Median(times[i]);
    std::printf("| %s | %.4f | %.4g | %.3f |\n", variants[i].name.c_str(), ms, 1000.0 / ms, Median(ratios[i]));
  }
  std::fflush(stdout);
}

std::vector<Problem> MakeProblems(Task task, int count) {
  SyntheticOptions options;
  options.split = "benchmark";
  options.outlier_ratio = {0.5, 0.5};
  const auto dataset = MakeSynthetic(task, options, 1);
  std::vector<Problem> problems;
  for (int i = 0; i < count; ++i) problems.push_back(dataset->Get(i).problem);
  return problems;
}

void EstimatorTable(const std::string& checkpoint, const std::vector<Problem>& problems, int threads, int rounds) {
  torch::set_num_threads(threads);
  EstimatorContext context;
  context.threads = threads;
  const auto make = [&](const std::string& yaml) {
    return std::shared_ptr<RobustEstimator>(MakeEstimator(ConfigFromYaml(yaml, "benchmark"), Task::kLine, context));
  };
  const std::string base = "{type: diffsac, checkpoint: '" + checkpoint + "'";
  std::vector<std::uint64_t> seeds(problems.size());
  std::vector<const Problem*> each;
  for (std::size_t i = 0; i < seeds.size(); ++i) seeds[i] = i;
  for (const Problem& problem : problems) each.push_back(&problem);
  int turn = 0;
  std::vector<Variant> variants;
  const auto one = [&](const std::string& name, const std::string& yaml) {
    variants.push_back(
        {name, [method = make(yaml), &problems, &turn] { method->Run(problems[turn++ % problems.size()], 1); }});
  };
  one("diffsac, one problem", base + "}");
  one("diffsac, one problem, 32 points decoded", base + ", max_decoded_points: 32}");
  one("diffsac, one problem, 10 steps", base + ", sampler: {steps: 10}}");
  one("diffsac, one problem, 2 steps", base + ", sampler: {steps: 2}}");
  for (const int size : {4, 16, 64}) {
    variants.push_back({"diffsac, batch of " + std::to_string(size) + ", 32 points decoded",
                        [method = make(base + ", max_decoded_points: 32}"), &each, &seeds, size] {
                          method->RunBatch({each.data(), static_cast<std::size_t>(size)},
                                           {seeds.data(), static_cast<std::size_t>(size)});
                        },
                        static_cast<double>(size)});
  }
  one("ransac 20", "{type: ransac, max_iterations: 20}");
  one("ransac 1000", "{type: ransac, max_iterations: 1000}");
  one("exhaustive", "{type: exhaustive}");
  Table("Estimators, one line problem (N = 100, κ = 20), " + std::to_string(threads) + " thread(s)", variants, rounds);
}

// κ copies through `steps` network calls, with a shared encoder or with the paper's joint network of the same depth.
void EncoderTable(int threads, int rounds, int steps) {
  torch::set_num_threads(threads);
  const c10::InferenceMode inference;
  std::vector<Variant> variants;
  const auto features = torch::randn({1, 100, 50});
  const auto c = torch::randn({1, 20, 100});
  for (const auto& [kind, width] : {std::pair<const char*, int>{"pooled", 64}, {"point_transformer", 64}}) {
    for (const int encoder_layers : {5, 4, 0}) {
      DenoiserOptions options;
      options.kind = FromString<DenoiserKind>(kind);
      options.width = width;
      options.encoder_layers = encoder_layers;
      options.layers = 6 - encoder_layers;
      options.inlier_head = false;
      std::shared_ptr<Denoiser> network = MakeDenoiser(options, 50, Rng(1));
      variants.push_back({std::string(kind) + " width 64, " + std::to_string(encoder_layers) + " encoder + " +
                              std::to_string(options.layers) + " decoder layers",
                          [=] {
                            const c10::InferenceMode guard;
                            const auto context = network->Encode({features, {}, {100}});
                            auto out = c;
                            for (int s = 0; s < steps; ++s)
                              out = network->Denoise(context, out, torch::full({1, 1}, 50.0f));
                          }});
    }
  }
  Table("Encode once against the joint network, total depth 6, κ = 20, " + std::to_string(steps) + " steps, " +
            std::to_string(threads) + " thread(s)",
        variants, rounds);
}

// A step of the decoder beside the matrix products it cannot do without, on tensors of the same shapes.
void StepTable(int threads, int rounds) {
  torch::set_num_threads(threads);
  const c10::InferenceMode inference;
  DenoiserOptions options;
  std::shared_ptr<Denoiser> network = MakeDenoiser(options, 50, Rng(1));
  const auto context = network->Encode({torch::randn({1, 100, 50}), {}, {100}});
  const auto c = torch::randn({1, 20, 100}), t = torch::full({1, 1}, 50.0f);
  const std::int64_t w = options.width;
  const auto x = torch::randn({2000, w}), hidden = torch::randn({2000, 2 * w}), pooled = torch::randn({20, 6 * w});
  const auto up = torch::randn({w, 2 * w}), down = torch::randn({2 * w, w}), attention = torch::randn({w, 4}),
             set = torch::randn({6 * w, 2 * w});
  const int layers = options.layers;
  Table("One denoiser step of the shipped size (κ = 20, N = 100), " + std::to_string(threads) + " thread(s)",
        {{"its matrix products alone",
          [=] {
            const c10::InferenceMode guard;
            for (int l = 0; l < layers; ++l) {
              torch::mm(x, up);
              torch::mm(hidden, down);
              torch::mm(x, attention);
              torch::mm(pooled, set);
            }
          }},
         {"the step",
          [=] {
            const c10::InferenceMode guard;
            network->Denoise(context, c, t);
          }}},
        rounds);
}

void HypothesesTable(const std::vector<Problem>& lines, const std::vector<Problem>& planes, int rounds) {
  EstimatorContext context;
  context.threads = 1;
  std::vector<Variant> variants;
  for (const auto& [name, task, problems] :
       {std::tuple{"lines", Task::kLine, &lines}, {"planes", Task::kPlane, &planes}}) {
    std::shared_ptr<RobustEstimator> method =
        MakeEstimator(ConfigFromYaml("{type: ransac, max_iterations: 10000}", "benchmark"), task, context);
    variants.push_back({std::string("ransac hypothesis, ") + name, [=] { method->Run((*problems)[0], 1); }, 10000.0});
  }
  Table("Hypotheses solved and scored against N = 100 points, 1 thread", variants, rounds);
}

}  // namespace
}  // namespace diffsac

int main(int argc, char** argv) {
  CLI::App app{"Speed on this machine"};
  std::string checkpoint = "models/line/model.safetensors";
  int rounds = 21;
  std::vector<int> threads = {1, 2};
  app.add_option("--checkpoint", checkpoint, "A line model");
  app.add_option("--rounds", rounds, "Rounds; figures are medians")->check(CLI::PositiveNumber);
  app.add_option("--threads", threads, "Thread counts")->delimiter(',');
  CLI11_PARSE(app, argc, argv);
  try {
    std::printf("%s\n%s\n", diffsac::VersionText("diffsac_benchmark").c_str(), diffsac::MachineText().c_str());
    const auto lines = diffsac::MakeProblems(diffsac::Task::kLine, 64);
    const auto planes = diffsac::MakeProblems(diffsac::Task::kPlane, 4);
    for (const int count : threads) diffsac::EstimatorTable(checkpoint, lines, count, rounds);
    for (const int count : threads) diffsac::EncoderTable(count, rounds, 10);
    for (const int count : threads) diffsac::StepTable(count, rounds);
    diffsac::HypothesesTable(lines, planes, rounds);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "diffsac_benchmark: %s\n", error.what());
    return 2;
  }
  return 0;
}
