#include "lab/config/compose.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;

std::string Composed(const std::string& text) { return ToYaml(ComposeExperiment(ConfigFromYaml(text, "x.yaml"))); }

Config Row(const std::string& text, int index) {
  return ComposeExperiment(ConfigFromYaml(text, "x.yaml")).Sub("methods." + std::to_string(index));
}

TEST_CASE("a plain experiment stays as it is, but for the folder of data") {
  const std::string plain = "name: \"a\"\nmethods:\n  - name: \"b\"\n    type: ransac\n";
  CHECK(Composed(plain) == plain + "data_root: \"data\"\n");
  CHECK(Composed(Composed(plain)) == Composed(plain));
  CHECK(Composed("") == "data_root: \"data\"\n");
}

TEST_CASE("methods are put on the presets that they name") {
  const std::string text = R"(
presets:
  plain: {consensus: {score: msac, refit: none}}
  network: {type: diffsac, num_diffusion_samples: 20, preset: [plain, recommended]}
  recommended: {temperature: 2, preset: recommended}
methods:
  a: {preset: network, label: A}
  b: {preset: [network, plain], num_diffusion_samples: 5, consensus: {refit: em}}
  network:
)";
  CHECK(Row(text, 0).Text("name") == "a");
  CHECK(Row(text, 0).Text("type") == "diffsac");
  CHECK(Row(text, 0).Text("consensus.score") == "msac");
  CHECK(Row(text, 0).Text("temperature") == "2");
  CHECK(Row(text, 0).Text("preset") == "recommended");  // The type's own.
  CHECK(Row(text, 1).Text("num_diffusion_samples") == "5");
  CHECK(Row(text, 1).Text("consensus.refit") == "em");
  CHECK(Row(text, 1).Text("consensus.score") == "msac");
  CHECK(Row(text, 2).Text("num_diffusion_samples") == "20");
  CHECK_THAT(Composed(text), !Contains("presets"));
}

TEST_CASE("methods and presets of several files come together by name") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("rows.yaml"),
                      "presets: {net: {type: diffsac}}\n"
                      "methods:\n  a: {preset: net, checkpoint: m.safetensors}\n");
  WriteFileAtomically(folder.File("more.yaml"), "methods:\n  b: {type: ransac}\n");
  WriteFileAtomically(folder.File("table.yaml"),
                      "include: [rows.yaml, more.yaml]\n"
                      "presets: {net: {num_diffusion_samples: 3}}\nmethods: {a: {label: Mine}, net}\n");
  Config config = ConfigFromFile(folder.File("table.yaml"));
  SetYaml(&config, "methods.b.max_iterations=7");
  SetYaml(&config, "methods.net.temperature=2");
  const auto rows = ComposeExperiment(config).Sequence("methods");
  REQUIRE(rows.size() == 3);
  CHECK(rows[0].Text("label") == "Mine");
  CHECK(rows[0].Text("checkpoint") == "m.safetensors");
  CHECK(rows[0].Text("num_diffusion_samples") == "3");
  CHECK(rows[1].Text("max_iterations") == "7");
  CHECK(rows[2].Text("temperature") == "2");
}

TEST_CASE("a swept method is a row for each combination") {
  const std::string text = R"(
presets: {uniform: {type: ransac}, grid: {sweep: {order: {uniform: {preset: uniform}, ratio: {type: prosac}}}}}
methods:
  to: {type: ransac, label: RANSAC to, sweep: {max_iterations: [10, 100]}}
  prior: {type: ransac, sweep: {consensus.sigma_prior: [0.5]}}
  msac: {preset: grid, label: "msac, *, * draws", sweep: {draws: {few: {max_iterations: 5}}}}
)";
  CHECK(Row(text, 0).Text("name") == "to_10");
  CHECK(Row(text, 1).Text("label") == "RANSAC to 100");
  CHECK(Row(text, 1).Text("max_iterations") == "100");
  CHECK(Row(text, 2).Text("consensus.sigma_prior") == "0.5");
  CHECK(Row(text, 3).Text("name") == "msac_uniform_few");
  CHECK(Row(text, 3).Text("type") == "ransac");
  CHECK(Row(text, 4).Text("label") == "msac, ratio, few draws");
  CHECK(Row(text, 4).Text("type") == "prosac");
  CHECK(Row(text, 4).Text("max_iterations") == "5");
  CHECK_THAT(Composed(text), !Contains("sweep"));
}

TEST_CASE("values of the experiment stand in texts") {
  const std::string text =
      "task: essential\nmetric: {pose: true}\nnotes: ${metric.pose}\n"
      "data: {paths: [\"${data_root}/a\", x]}\nmethods: {a: {type: diffsac, checkpoint: "
      "\"models/${task}/${task}.safetensors\"}}\n";
  const Config config = ComposeExperiment(ConfigFromYaml(text, "x.yaml"));
  CHECK(config.Text("notes") == "true");
  CHECK(config.Text("data.paths.0") == "data/a");
  CHECK(config.Text("methods.0.checkpoint") == "models/essential/essential.safetensors");
  Config set = ConfigFromYaml(text, "x.yaml");
  SetYaml(&set, "data_root='/my data'");
  CHECK(ComposeExperiment(set).Text("data.paths.0") == "/my data/a");
  CHECK_THROWS_WITH(Composed("name: a\nnotes: ${nmae}\n"), Contains("x.yaml:2") && Contains("${nmae}"));
  CHECK_THROWS_WITH(Composed("name: a${name}\n"), Contains("x.yaml:1"));
  CHECK_THROWS_WITH(Composed("notes: ${name\n"), Contains("x.yaml:1") && Contains("'}'"));
}

TEST_CASE("a sweep is a condition for each value") {
  const Config config = ComposeExperiment(ConfigFromYaml("sweep: {outlier_ratio: [0.1, 0.25]}\n"));
  REQUIRE(config.Sequence("conditions").size() == 2);
  CHECK(config.Text("conditions.1.name") == "0.25");
  CHECK(config.Text("conditions.1.value") == "0.25");
  CHECK(config.Text("conditions.1.data.outlier_ratio") == "0.25");
}

TEST_CASE("the first of several seeds is the seed, unless one is given") {
  const auto seed = [](const std::string& text) { return ComposeExperiment(ConfigFromYaml(text)).Text("seed"); };
  CHECK(seed("seeds: [4, 5]\n") == "4");
  CHECK(seed("seeds: [4, 5]\nseed: 1\n") == "1");
}

TEST_CASE("mistakes in compositions name file line and nearest") {
  const std::string row = "\n  a: {preset: plian}\n";
  CHECK_THROWS_WITH(Composed("presets: {plain: {num_diffusion_samples: 2}}\nmethods:" + row),
                    Contains("x.yaml:3") && Contains("did you mean 'plain'"));
  CHECK_THROWS_WITH(Composed("methods:" + row), Contains("x.yaml:2") && Contains("plian"));
  CHECK_THROWS_WITH(Composed("methods: {plian}"), Contains("x.yaml:1") && Contains("plian"));
  CHECK_THROWS_WITH(Composed("methods: {a: {preset: [plian, plain], type: ransac}}"), Contains("'plain'"));
  CHECK_THROWS_WITH(Composed("presets: {plian: {preset: b}, b: {preset: plian}}\nmethods:" + row), Contains("circle"));
  CHECK_THROWS_WITH(Composed("presets: [a]\nmethods:" + row), Contains("x.yaml:1") && Contains("expected a map"));
  CHECK_THROWS_WITH(Composed("methods: {a: {type: ransac, sweep: {b: 1}}}"), Contains("x.yaml:1: sweep.b"));
  CHECK_THROWS_WITH(Composed("methods: {a: ransac}\n"), Contains("x.yaml:1: methods.a"));
  CHECK_THROWS_WITH(Composed("methods: {a: {name: b}}\n"), Contains("its name already"));
  CHECK_THROWS_WITH(Composed("sweep: [0.1]\n"), Contains("x.yaml:1: sweep") && Contains("outlier_ratio"));
  CHECK_THROWS_WITH(Composed("sweep: {a: [1]}\nconditions: []\n"), Contains("x.yaml:1") && Contains("already"));
  CHECK_THROWS_WITH(Composed("sweep: {seed: [1, 2]}\n"), Contains("x.yaml:1") && Contains("'seeds: [1, 2]'"));
}

TEST_CASE("paths of an experiment are relative to its file, but not what --data-root begins") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "data/set");
  WriteFileAtomically(folder / "net.safetensors", "");
  WriteFileAtomically(folder / "table.yaml",
                      "methods: [{type: diffsac, checkpoint: net.safetensors}]\n"
                      "conditions: [{name: a, data: {paths: [\"${data_root}/set\", absent]}}]\n");
  Config config = ConfigFromFile(folder / "table.yaml");
  const Config found = ComposeExperiment(config);
  CHECK(found.Text("methods.0.checkpoint") == folder / "net.safetensors");
  CHECK(found.Text("conditions.0.data.paths.0") == folder / "data/set");
  CHECK(found.Text("conditions.0.data.paths.1") == "absent");
  SetYaml(&config, "data_root=data");
  CHECK(ComposeExperiment(config).Text("conditions.0.data.paths.0") == "data/set");
}

}  // namespace
}  // namespace diffsac
