#include <torch/torch.h>

#include "lab/config/make_estimator.h"

#include <catch2/catch.hpp>

#include <unistd.h>

#include <filesystem>

#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "estimate/tiny_network.h"
#include "lab/config/yaml.h"
#include "lab/torch/checkpoint.h"

namespace diffsac {
namespace {

struct SavedNetwork {
  std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("diffsac_registry_test_" + std::to_string(::getpid()));
  std::string path = (folder / "line.safetensors").string();
  SavedNetwork() {
    std::filesystem::create_directories(folder);
    const auto network = TinyNetwork(Task::kLine);
    const std::string config = "task: line\nname: tiny\nnetwork:\n" + Indent(WriteYaml(network->options)) +
                               "\ninference: {num_diffusion_samples: 7, sampler: {steps: 2}}\n";
    SaveCheckpoint(path, {"diffsac", "line", config, "r", 5, 1, -1}, *network->module,
                   ExponentialMovingAverage(*network->module, 0.9), nullptr);
  }
  ~SavedNetwork() { std::filesystem::remove_all(folder); }
  static std::string Indent(const std::string& text) {
    std::string out = "  ";
    for (const char c : text) out += c == '\n' ? "\n  " : std::string(1, c);
    return out;
  }
};

std::unique_ptr<RobustEstimator> Make(const std::string& yaml, Task task = Task::kLine,
                                      const std::string& checkpoint = "") {
  return MakeEstimator(ConfigFromYaml(yaml, "t.yaml"), task, {checkpoint, "cpu", 1});
}

}  // namespace

TEST_CASE("rows are built by name, and a wrong name is an error with the nearest one") {
  CHECK(Make("{type: ransac, max_iterations: 20}") != nullptr);
  CHECK_THROWS_WITH(Make("{type: ransak}"), Catch::Contains("t.yaml:1") && Catch::Contains("did you mean 'ransac'"));
  CHECK_THROWS_WITH(Make("{max_iterations: 20}"), Catch::Contains("type"));
  CHECK_THROWS_WITH(Make("{type: ransac, max_iterations: 20, max_iteration: 3}"), Catch::Contains("max_iterations"));
}

TEST_CASE("a row without a network takes its budget from its consensus as well, where that is lower") {
  const auto budget = [](const std::string& keys) {
    const Config row = ResolvedRow(ConfigFromYaml("{type: ransac, " + keys + "}", "t.yaml"), Task::kLine, {});
    CHECK(row.Text("consensus.max_iterations") == row.Text("max_iterations"));
    return row.Text("max_iterations");
  };
  CHECK(budget("max_iterations: 50") == "50");
  CHECK(budget("consensus: {max_iterations: 40}") == "40");
  CHECK(budget("max_iterations: 50, consensus: {max_iterations: 40}") == "40");
  CHECK_THROWS_WITH(budget("max_iterations: 50, consensus: {max_iterations: 60}"), Catch::Contains("at most"));
}

TEST_CASE("a diffsac row takes its defaults from the checkpoint and overrides them key by key") {
  const SavedNetwork saved;
  const auto problem = TinyExamples(Task::kLine, 1)[0].problem;
  const auto budget = [&](const std::string& more) {
    const auto method = Make("{type: diffsac, checkpoint: '" + saved.path + "', consensus: {refit: none}" + more + "}");
    return method->Run(problem, 1).stats.hypotheses;
  };
  CHECK(budget("") == 30 + 7);
  CHECK(budget(", num_diffusion_samples: 9") == 30 + 9);
  CHECK(Make("{type: diffsac, checkpoint: none.safetensors, num_diffusion_samples: 3}", Task::kLine, saved.path) !=
        nullptr);
}

TEST_CASE("a resolved row has every key that acts, and makes the same method") {
  const auto resolve = [](const std::string& yaml, Task task) {
    return ResolvedRow(ConfigFromYaml(yaml, "t.yaml"), task, {});
  };
  const Config row = resolve("{type: magsac_pp, max_iterations: 30}", Task::kFundamental);
  CHECK(row.Text("type") == "magsac_pp");
  CHECK(row.Text("max_iterations") == "30");
  CHECK(row.Text("consensus.score") == "magsac_pp");
  CHECK(row.Text("consensus.final_refinement") == "lm");
  CHECK(ToYaml(ResolvedRow(row, Task::kFundamental, {})) == ToYaml(row));
  CHECK(resolve("{type: magsac_pp}", Task::kLine).Text("consensus.final_refinement") == "none");
  CHECK(ToYaml(resolve("{type: oracle}", Task::kLine)) == "type: oracle\n");
  CHECK_THROWS_WITH(resolve("{type: oracle, max_iterations: 3}", Task::kLine),
                    Catch::Contains("unknown key 'max_iterations'"));
  CHECK_THROWS_WITH(resolve("{type: theil_sen}", Task::kFundamental),
                    Catch::Contains("t.yaml:1: type: theil_sen estimates lines and planes only"));
}

TEST_CASE("a resolved diffsac row has its checkpoint's inference group under its own keys") {
  const SavedNetwork saved;
  const Config own =
      ConfigFromYaml("{type: diffsac, checkpoint: '" + saved.path + "', num_guided_samples: 3}", "t.yaml");
  const Config row = ResolvedRow(own, Task::kLine, {});
  CHECK(row.Text("checkpoint") == saved.path);
  CHECK(row.Text("num_diffusion_samples") == "7");
  CHECK(row.Text("sampler.steps") == "2");
  CHECK(row.Text("num_guided_samples") == "3");
  CHECK(ToYaml(ResolvedRow(row, Task::kLine, {})) == ToYaml(row));
}

TEST_CASE("a diffsac row that cannot be built is a clear error") {
  const SavedNetwork saved;
  CHECK_THROWS_WITH(Make("{type: diffsac}"), Catch::Contains("checkpoint"));
  CHECK_THROWS_WITH(Make("{type: diffsac, checkpoint: none.safetensors}"), Catch::Contains("none.safetensors"));
  CHECK_THROWS_WITH(Make("{type: diffsac, checkpoint: '" + saved.path + "'}", Task::kPlane),
                    Catch::Contains("line") && Catch::Contains("plane"));
  CHECK_THROWS_WITH(Make("{type: diffsac, checkpoint: '" + saved.path + "', num_diffusion_sample: 3}"),
                    Catch::Contains("num_diffusion_samples"));
}

TEST_CASE("a key that changes nothing in a diffsac row is an error with its line, an inherited one is not") {
  const SavedNetwork saved;
  const std::string row = "{type: diffsac, checkpoint: '" + saved.path + "', ";
  for (const char* keys :
       {"selection: gumbel, temperature: 0.5", "num_guided_samples: 5, temperature: 0.5",
        "num_diffusion_samples: 0, num_guided_samples: 9, temperature: 0.5",
        "num_diffusion_samples: 0, num_guided_samples: 9, selection: gumbel",
        "selection: gumbel, intermediate_sets: false", "num_uniform_samples: 4, extra_sampler: prosac",
        "consensus: {stopping: confidence, max_iterations: 50}"})
    CHECK_NOTHROW(Make(row + keys + "}"));
  for (const char* keys :
       {"temperature: 0.5", "num_diffusion_samples: 0, num_guided_samples: 9, sampler: {steps: 1}",
        "num_diffusion_samples: 0", "num_diffusion_samples: 0, num_guided_samples: 9, selection: probabilistic",
        "num_diffusion_samples: 0, num_guided_samples: 9, max_decoded_points: 5",
        "selection: gumbel, intermediate_sets: true", "extra_sampler: prosac", "model: fundamental8",
        "consensus: {max_iterations: 50}", "consensus: {min_iterations: 5}"}) {
    CAPTURE(keys);
    CHECK_THROWS_WITH(Make("# a row\n" + row + keys + "}"), Catch::Contains("t.yaml:2"));
  }
}

}  // namespace diffsac
