#include "lab/options/options.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;

struct ModelOptions {
  int width = 64;
  double rate = 0.1;
  bool bias = true;
  void Bind(OptionsBinder& b) {
    b.Field("width", width, Within(1, 512));
    b.Field("rate", rate, Positive());
    b.Field("bias", bias);
  }
};

struct AllOptions {
  std::int64_t steps = 10;
  std::uint64_t seed = 1;
  std::string name = "a";
  Range ratio{0.1, 0.8};
  std::vector<double> scales = {0.5};
  std::vector<int> sizes = {1, 2};
  std::vector<std::string> words;
  std::string noise = "gaussian";
  std::vector<std::string> methods = {"ransac"};
  ModelOptions model;
  int min_size = 1;
  void Bind(OptionsBinder& b) {
    b.Field("steps", steps, AtLeast(0));
    b.Field("seed", seed);
    b.Field("name", name);
    b.Field("ratio", ratio, Within(0.0, 1.0));
    b.Field("scales", scales, Positive());
    b.Field("sizes", sizes, AtLeast(1));
    b.Field("words", words);
    b.Choice("noise", noise, {"gaussian", "uniform"});
    b.Choices("methods", methods, {"ransac", "oracle"});
    b.Group("model", model);
    b.Field("min_size", min_size);
    b.Require(min_size <= steps, "min_size", "at most 'steps'");
  }
};

AllOptions Read(const std::string& yaml) { return ReadOptions<AllOptions>(ConfigFromYaml(yaml, "f.yaml")); }

AllOptions ReadSet(const std::string& assignment) {
  Config config = ConfigFromYaml("model: {width: 3}\nsizes: [1, 2]\n", "f.yaml");
  SetYaml(&config, assignment);
  return ReadOptions<AllOptions>(config);
}

}  // namespace

TEST_CASE("Values of every kind are read") {
  const AllOptions o = Read(
      "steps: 5\nseed: 18446744073709551615\nname: 12\nratio: [0.2, 0.3]\nscales: [1, 2e-3]\nsizes: []\n"
      "words: [x, 'y z']\nnoise: uniform\nmethods: [oracle, ransac]\nmodel:\n  width: +7\n  rate: 1\n  bias: no\n");
  CHECK(o.steps == 5);
  CHECK(o.seed == std::numeric_limits<std::uint64_t>::max());
  CHECK(o.name == "12");
  CHECK(o.ratio == Range(0.2, 0.3));
  CHECK(o.scales == std::vector<double>{1.0, 2e-3});
  CHECK(o.sizes.empty());
  CHECK(o.words == std::vector<std::string>{"x", "y z"});
  CHECK(o.noise == "uniform");
  CHECK(o.methods == std::vector<std::string>{"oracle", "ransac"});
  CHECK(o.model.width == 7);
  CHECK(o.model.rate == 1.0);
  CHECK_FALSE(o.model.bias);
  CHECK(Read("ratio: 0.5").ratio == Range(0.5));
}

TEST_CASE("Nothing given leaves the defaults") {
  const std::string defaults = WriteYaml(AllOptions());
  CHECK(WriteYaml(Read("")) == defaults);
  CHECK(WriteYaml(Read("# only a comment\n")) == defaults);
  CHECK(WriteYaml(Read("model:\n")) == defaults);
  CHECK(WriteYaml(ReadOptions<AllOptions>(Config())) == defaults);
  CHECK(WriteYaml(ReadOptions<AllOptions>(Config().Sub("not.there"))) == defaults);
}

TEST_CASE("Every mistake names its place and what was expected") {
  const auto [yaml, message] = GENERATE(table<std::string, std::string>({
      {"steps: 1\nmodel:\n  widht: 3\n", "f.yaml:3: unknown key 'model.widht'; did you mean 'width'?"},
      {"\nstpes: 1\n", "f.yaml:2: unknown key 'stpes'; did you mean 'steps'?"},
      {"model:\n  width: abc\n", "f.yaml:2: model.width: expected an integer from 1 to 512, got 'abc'"},
      {"model: {width: 1.5}", "f.yaml:1: model.width: expected an integer from 1 to 512, got '1.5'"},
      {"model: {width: 513}", "f.yaml:1: model.width: expected an integer from 1 to 512, got '513'"},
      {"min_size: 3000000000", "f.yaml:1: min_size: expected an integer, got '3000000000'"},
      {"model: {rate: 0}", "f.yaml:1: model.rate: expected a number above 0, got '0'"},
      {"model: {rate: .inf}", "f.yaml:1: model.rate: expected a number above 0, got '.inf'"},
      {"model: {rate: nan}", "f.yaml:1: model.rate: expected a number above 0, got 'nan'"},
      {"model: {rate: }", "f.yaml:1: model.rate: expected a number above 0, got nothing"},
      {"model: {bias: 1}", "f.yaml:1: model.bias: expected true or false, got '1'"},
      {"model: 3", "f.yaml:1: model: expected a map of options, got '3'"},
      {"steps: -1", "f.yaml:1: steps: expected an integer of at least 0, got '-1'"},
      {"steps: [1]", "f.yaml:1: steps: expected an integer of at least 0, got a list"},
      {"seed: -1", "f.yaml:1: seed: expected an integer of at least 0, got '-1'"},
      {"name: {a: 1}", "f.yaml:1: name: expected a text, got a map"},
      {"ratio: [0.5, 1.5]", "f.yaml:1: ratio: expected a number or a range [low, high], from 0 to 1, got a list"},
      {"ratio: [0.5, 0.1]", "f.yaml:1: ratio: expected a number or a range [low, high], from 0 to 1, got a list"},
      {"ratio: [0.5]", "f.yaml:1: ratio: expected a number or a range [low, high], from 0 to 1, got a list"},
      {"scales: 0.5", "f.yaml:1: scales: expected a list of numbers, got '0.5'"},
      {"scales:\n- 1\n- 0\n", "f.yaml:3: scales.1: expected a number above 0, got '0'"},
      {"sizes: [1, x]", "f.yaml:1: sizes.1: expected an integer of at least 1, got 'x'"},
      {"words: [[a]]", "f.yaml:1: words.0: expected a text, got a list"},
      {"noise: unifrom", "f.yaml:1: noise: expected one of gaussian, uniform, got 'unifrom'; did you mean 'uniform'?"},
      {"methods: [orcale]",
       "f.yaml:1: methods.0: expected one of ransac, oracle, got 'orcale'; did you mean 'oracle'?"},
      {"steps: 2\nmin_size: 3\n", "f.yaml:2: min_size: expected at most 'steps'"},
      {"min_size: 20\nstesp: 30\n", "f.yaml:2: unknown key 'stesp'; did you mean 'steps'?"},
      {"steps: 1\nname: a\nsteps: 2\n", "f.yaml:3: duplicate key 'steps'"},
      {"model:\n  width: 1\n  width: 1\n", "f.yaml:3: duplicate key 'width'"},
      {"- 1\n- 2\n", "f.yaml:1: expected a map of options (key: value)"},
      {"[a]: 1", "f.yaml:1: expected a plain word as key"},
  }));
  CHECK_THROWS_AS(Read(yaml), Error);
  CHECK_THROWS_WITH(Read(yaml), message);
}

TEST_CASE("Broken YAML names the line") {
  CHECK_THROWS_WITH(Read("steps: 1\nsizes: [1, 2\n"), Catch::StartsWith("f.yaml:") && Contains("not valid YAML"));
  CHECK_THROWS_WITH(Read("a: 1\n---\nb: 2\n"), Contains("expected a single YAML document"));
  CHECK_THROWS_AS(Read("a: &x [*x]\n"), Error);
  // Was read, but written again it began with the mark of UTF-16.
  CHECK_THROWS_WITH(Read("# a comment\n\xFE\xFF\xFF\xEEsteps: 1\n"), Catch::StartsWith("f.yaml") && Contains("UTF-8"));
  CHECK_THROWS_WITH(Read(std::string("na\0me: x\n", 9)), Contains("UTF-8"));
  CHECK(Read("# \xC3\xA9\nsteps: 7\n").steps == 7);
}

TEST_CASE("YAML that the parser would never finish, or that would take minutes, ends with an error") {
  // yaml-cpp 0.7 sees endlessly many documents in this.
  CHECK_THROWS_WITH(Read("&\","), Catch::StartsWith("f.yaml") && Contains("YAML"));
  CHECK_THROWS_WITH(Read(std::string(100000, '[')), Contains("not valid YAML"));
  std::string many;
  for (int i = 0; i < 60000; ++i) many += "a" + std::to_string(i) + ":\n";
  CHECK_THROWS_WITH(Read(many), Contains("too many values"));
  CHECK(Read("# a comment alone\n---\n").name == AllOptions().name);
}

TEST_CASE("The option --set changes values and is named in messages") {
  CHECK(ReadSet("model.width=5").model.width == 5);
  CHECK(ReadSet("name=a=b").name == "a=b");
  CHECK(ReadSet("sizes.1=9").sizes == std::vector<int>{1, 9});
  CHECK(ReadSet("scales=[1, 2]").scales == std::vector<double>{1, 2});
  CHECK(ReadSet("model={rate: 2}").model.width == 64);
  const auto [assignment, message] = GENERATE(table<std::string, std::string>({
      {"min_size=abc", "--set min_size=abc: expected an integer"},
      {"model.width=0", "--set model.width=0: expected an integer from 1 to 512"},
      {"model={width: x}", "--set model={width: x}: model.width: expected an integer from 1 to 512, got 'x'"},
      {"model.widht=3", "--set model.widht=3: unknown key 'model.widht'; did you mean 'width'?"},
      {"noise=x", "--set noise=x: expected one of gaussian, uniform; did you mean 'uniform'?"},
      {"min_size=20", "--set min_size=20: expected at most 'steps'"},
      {"sizes.0=0", "--set sizes.0=0: expected an integer of at least 1"},
      {"steps", "--set steps: expected key.path=value"},
      {"=3", "--set =3: expected key.path=value"},
      {"a..b=3", "--set a..b=3: expected key.path=value"},
      {"model.width.x=3", "--set model.width.x=3: 'model.width' is a value, not a map"},
      {"sizes.2=3", "--set sizes.2=3: 'sizes' is a list of 2, expected an index below that instead of '2'"},
  }));
  CAPTURE(assignment);
  CHECK_THROWS_WITH(ReadSet(assignment), message);
}

TEST_CASE("The option --set reaches into missing maps and lists of maps") {
  Config config = ConfigFromYaml("methods:\n- name: a\n- name: b\n");
  SetYaml(&config, "methods.0.max_iterations=5");
  SetYaml(&config, "x.y.z=1");
  CHECK(config.Has("x.y.z"));
  CHECK(config.Sequence("methods")[0].Has("max_iterations"));
  CHECK_FALSE(config.Sequence("methods")[1].Has("max_iterations"));
  CHECK_THROWS_AS(SetYaml(&config, "methods.0.name.deep=1"), Error);
  CHECK_THROWS_WITH(SetYaml(&config, "q=[1"), Contains("--set q=[1: not valid YAML"));
  CHECK_FALSE(config.Has("q"));
}

TEST_CASE("Views share the document and keep the whole path") {
  Config config = ConfigFromYaml("a:\n  b:\n    width: x\n  list:\n  - {width: 1}\n  - {width: y}\n", "f.yaml");
  const Config copy = config;
  CHECK(config.Sub("a").Sub("b").Where("width") == "f.yaml:3: a.b.width");
  CHECK(config.Where("a.b.other") == "f.yaml:2: a.b.other");
  CHECK(config.Where("nothing") == "f.yaml: nothing");
  CHECK_THROWS_WITH(ReadOptions<ModelOptions>(config.Sub("a.b")), Catch::StartsWith("f.yaml:3: a.b.width: "));
  const auto items = config.Sequence("a.list");
  REQUIRE(items.size() == 2);
  CHECK(ReadOptions<ModelOptions>(items[0]).width == 1);
  CHECK_THROWS_WITH(ReadOptions<ModelOptions>(items[1]), Catch::StartsWith("f.yaml:6: a.list.1.width: "));
  CHECK(config.Sequence("none").empty());
  CHECK_THROWS_WITH(config.Sequence("a.b"), "f.yaml:2: a.b: expected a list");
  CHECK_THROWS_WITH(config.Sub("a.b.width.c"), "f.yaml:3: a.b.width: expected a map of options");
  Config part = config.Sub("a");
  SetYaml(&part, "b.width=4");
  CHECK(ToYaml(copy.Sub("a.b")) == "width: 4\n");
  CHECK(copy.Where("a.b.width") == "--set a.b.width=4");
}

TEST_CASE("include merges maps, replaces lists and keeps places") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("base.yaml"), "sizes: [1, 2, 3]\nmodel:\n  width: 5\n  rate: -1\nsteps: 7\n");
  WriteFileAtomically(folder.File("main.yaml"), "include: base.yaml\nsizes: [4]\nmodel:\n  width: 6\n");
  Config config = ConfigFromFile(folder.File("main.yaml"));
  CHECK(config.Where("model.width") == folder.File("main.yaml") + ":4: model.width");
  CHECK(config.Where("steps") == folder.File("base.yaml") + ":5: steps");
  CHECK_THROWS_WITH(ReadOptions<AllOptions>(config), Catch::StartsWith(folder.File("base.yaml") + ":4: model.rate: "));
  SetYaml(&config, "model.rate=0.5");
  const auto options = ReadOptions<AllOptions>(config);
  CHECK(options.sizes == std::vector<int>{4});
  CHECK(options.model.width == 6);
  CHECK(options.steps == 7);
}

TEST_CASE("include: of a list of files the later ones override, and the file itself all of them") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("a.yaml"), "name: a\nsteps: 3\nmodel: {width: 5}\n");
  WriteFileAtomically(folder.File("b.yaml"), "name: b\nsteps: 4\nmodel: {rate: 0.5}\n");
  WriteFileAtomically(folder.File("main.yaml"), "include: [a.yaml, b.yaml]\nname: main\n");
  const auto options = ReadOptions<AllOptions>(ConfigFromFile(folder.File("main.yaml")));
  CHECK(options.name == "main");
  CHECK(options.steps == 4);
  CHECK(options.model.width == 5);
  CHECK(options.model.rate == 0.5);
  WriteFileAtomically(folder.File("main.yaml"), "include: [a.yaml, [b.yaml]]\n");
  CHECK_THROWS_WITH(ConfigFromFile(folder.File("main.yaml")), Contains("main.yaml:1: include: ") && Contains("list"));
  WriteFileAtomically(folder.File("main.yaml"), "include:\n  - a.yaml\n  - none.yaml\n");
  CHECK_THROWS_WITH(ConfigFromFile(folder.File("main.yaml")),
                    Contains("main.yaml:3: include: ") && Contains("none.yaml"));
}

TEST_CASE("include: chains are followed, circles and absent files are errors") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("a.yaml"), "include: b.yaml\nname: a\n");
  WriteFileAtomically(folder.File("b.yaml"), "include: ./c.yaml\nname: b\nsteps: 8\n");
  WriteFileAtomically(folder.File("c.yaml"), "steps: 3\nseed: 9\n");
  const auto options = ReadOptions<AllOptions>(ConfigFromFile(folder.File("a.yaml")));
  CHECK(options.name == "a");
  CHECK(options.steps == 8);
  CHECK(options.seed == 9);
  WriteFileAtomically(folder.File("c.yaml"), "\ninclude: a.yaml\n");
  CHECK_THROWS_WITH(ConfigFromFile(folder.File("a.yaml")), Contains("c.yaml:2: include: ") && Contains("itself"));
  // It has no end.
  WriteFileAtomically(folder.File("c.yaml"), "include: /dev/zero\n");
  CHECK_THROWS_WITH(ConfigFromFile(folder.File("a.yaml")), Contains("c.yaml:1: include: ") && Contains("not a file"));
  WriteFileAtomically(folder.File("c.yaml"), "include: none.yaml\n");
  CHECK_THROWS_WITH(ConfigFromFile(folder.File("a.yaml")), Contains("c.yaml:1: include: ") && Contains("none.yaml"));
  CHECK_THROWS_WITH(ConfigFromFile(folder.File("none.yaml")), Contains("none.yaml") && Contains("No such file"));
}

TEST_CASE("Written options read back equal") {
  AllOptions o;
  o.name = GENERATE("", "true", "5", "null", "~", "a: b # c", "- x", "two\nlines", "it's \"quoted\"", "[1, 2]", "é");
  o.seed = std::numeric_limits<std::uint64_t>::max();
  o.ratio = Range(1.0 / 3.0, 0.7);
  o.scales = {0.1, 1e-300, 1.0 / 3.0, 1e22, std::nextafter(1.0, 2.0), 5e-324};
  o.words = {"", "x, y", "-1", "null"};
  o.model.rate = 1e-4;
  o.model.bias = false;
  const std::string yaml = WriteYaml(o);
  CAPTURE(yaml);
  const AllOptions back = Read(yaml);
  CHECK(back.name == o.name);
  CHECK(back.seed == o.seed);
  CHECK(back.ratio == o.ratio);
  CHECK(back.scales == o.scales);
  CHECK(back.words == o.words);
  CHECK(back.model.rate == o.model.rate);
  CHECK(back.model.bias == o.model.bias);
  CHECK(WriteYaml(back) == yaml);
  CHECK(ToYaml(ConfigFromYaml(yaml)) == yaml);
  o.model.rate = std::nan("");
  CHECK_THROWS_AS(WriteYaml(o), std::logic_error);
}

TEST_CASE("NearestWord is the smallest edit distance, the first of equals") {
  CHECK(NearestWord("widht", {"height", "width", "depth"}) == "width");
  CHECK(NearestWord("x", {"ab", "cd"}) == "ab");
  CHECK(NearestWord("x", {}).empty());
}

}  // namespace diffsac

TEST_CASE("a plain value can be read as text without knowing the other keys") {
  const auto config = diffsac::ConfigFromYaml("type: ransac\nname: \"a b\"\nmap: {x: 1}\n", "t.yaml");
  CHECK(config.Text("type") == "ransac");
  CHECK(config.Text("name") == "a b");
  CHECK(config.Text("map.x") == "1");
  CHECK_THROWS_WITH(config.Text("map"), Catch::Contains("t.yaml:3"));
  CHECK_THROWS_WITH(config.Text("none"), Catch::Contains("plain value"));
}
