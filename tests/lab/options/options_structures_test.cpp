#include <catch2/catch.hpp>
#include <limits>
#include <optional>

#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/options/options.h"

// What a field can be besides a number or a text: enums, lists of structs, optional values, sub-documents.

namespace diffsac {
namespace {

using Catch::Contains;

enum class Noise { kGaussian, kUniform, kNone };

}  // namespace

template <>
inline constexpr auto kEnumNames<Noise> =
    NamesOf<Noise>({{Noise::kGaussian, "gaussian"}, {Noise::kUniform, "uniform"}, {Noise::kNone, "none"}});

namespace {

struct NoiseOptions {
  Noise noise = Noise::kGaussian;
  Noise other = Noise::kUniform;
  std::vector<Noise> all = {Noise::kNone};
  double sigma = 1.0;
  void Bind(OptionsBinder& b) {
    b.Field("noise", noise).Help("how inliers scatter");
    b.Field("other", other, {Noise::kGaussian, Noise::kUniform});
    b.Field("all", all);
    b.Field("sigma", sigma, Positive()).OnlyIf(noise == Noise::kGaussian, "noise: gaussian").Help("pixels");
  }
};

struct Row {
  std::string name;
  std::optional<int> problems;
  Config own;
  void Bind(OptionsBinder& b) {
    b.Field("name", name);
    b.Field("problems", problems, AtLeast(1));
    b.Rest(own);
  }
};

struct TableOptions {
  std::vector<Row> rows;
  Config data;
  void Bind(OptionsBinder& b) {
    b.Field("rows", rows);
    b.Field("data", data);
    for (std::size_t i = 0; i < rows.size(); ++i)
      b.Reject(rows[i].name == "bad", "rows." + std::to_string(i), "no row is named bad");
  }
};

template <class Options>
Options Read(const std::string& yaml) {
  return ReadOptions<Options>(ConfigFromYaml(yaml, "f.yaml"));
}

}  // namespace

/// Options of 0.3 whose keys, and a value of which, had other names in 0.2.
struct RenamedOptions {
  int finalists = 0, starts = 0;
  std::string score = "msac";
  void Bind(OptionsBinder& b) {
    b.Field("num_finalists", finalists, AtLeast(0)).OnlyIf(starts > 0 || finalists > 0, "something else");
    b.Field("lo_starts", starts);
    b.Choice("score", score, {"msac", "mlesac"});
  }
};

TEST_CASE("Former names are read and current ones written") {
  const auto read = [](const char* yaml) { return ReadOptions<RenamedOptions>(ConfigFromYaml(yaml, "f.yaml")); };
  const RenamedOptions options = read("{refine_finalists: 3, basins: 2, score: gaussian_uniform}");
  CHECK(options.finalists == 3);
  CHECK(options.starts == 2);
  CHECK(options.score == "mlesac");
  CHECK(WriteYaml(options) == WriteYaml(read("{num_finalists: 3, lo_starts: 2, score: mlesac}")));
  CHECK_THROWS_WITH(read("{num_finalists: 3, refine_finalists: 4}"), Contains("unknown key 'refine_finalists'"));
  CHECK_THROWS_WITH(read("{refine_finalists: -1}"), Contains("num_finalists: expected an integer of at least 0"));
  CHECK_THROWS_WITH(read("{score: energy}"), Contains("expected one of msac, mlesac"));
}

TEST_CASE("An enum is bound by the names in its table") {
  const auto options = Read<NoiseOptions>("noise: uniform\nother: gaussian\nall: [none, uniform]\n");
  CHECK(options.noise == Noise::kUniform);
  CHECK(options.other == Noise::kGaussian);
  CHECK(options.all == std::vector<Noise>{Noise::kNone, Noise::kUniform});
  CHECK(WriteYaml(options) == "noise: uniform\nother: gaussian\nall: [none, uniform]\n");
  CHECK(ToString(Noise::kNone) == "none");
  CHECK(FromString<Noise>("none") == Noise::kNone);
  CHECK_THROWS_WITH(FromString<Noise>("nine"),
                    "expected one of gaussian, uniform, none, got 'nine'; did you mean 'none'?");
  CHECK_THROWS_AS(ToString(static_cast<Noise>(7)), std::logic_error);
  CHECK_THROWS_WITH(Read<NoiseOptions>("noise: unifrom"),
                    "f.yaml:1: noise: expected one of gaussian, uniform, none, got 'unifrom'; did you mean 'uniform'?");
  CHECK_THROWS_WITH(Read<NoiseOptions>("other: none"),
                    Contains("other: expected one of gaussian, uniform, got 'none'"));
  CHECK_THROWS_WITH(Read<NoiseOptions>("all: [none, x]"), Contains("f.yaml:1: all.1: expected one of gaussian"));
}

TEST_CASE("A key that does not act is an error with its line, and is not written") {
  CHECK(Read<NoiseOptions>("noise: gaussian\nsigma: 2\n").sigma == 2.0);
  CHECK_THROWS_WITH(Read<NoiseOptions>("noise: none\nsigma: 2\n"), "f.yaml:2: sigma: acts only with noise: gaussian");
  CHECK_THROWS_WITH(Read<NoiseOptions>("noise: none\nsigma: 2\nothr: uniform\n"), Contains("unknown key 'othr'"));
  CHECK(WriteYaml(Read<NoiseOptions>("noise: none")) == "noise: none\nother: uniform\nall: [none]\n");
}

TEST_CASE("What was stored earlier may hold keys that are gone or do not act, but no wrong values") {
  const auto stored = [](const std::string& yaml) {
    return ReadStoredOptions<NoiseOptions>(ConfigFromYaml(yaml, "f.yaml"));
  };
  CHECK(stored("noise: none\nsigma: 2\ngone: 3\n").noise == Noise::kNone);
  CHECK_THROWS_WITH(stored("sigma: 0"), Contains("f.yaml:1: sigma: expected a number above 0"));
}

TEST_CASE("Lists of structs and sub-documents keep their places") {
  const auto table = Read<TableOptions>("rows:\n- name: a\n- {name: b, problems: 3, copies: 7}\ndata:\n  type: line\n");
  REQUIRE(table.rows.size() == 2);
  CHECK(table.rows[0].name == "a");
  CHECK_FALSE(table.rows[0].problems);
  CHECK(table.rows[1].problems == 3);
  CHECK(ToYaml(table.rows[1].own) == "copies: 7\n");
  CHECK(table.rows[1].own.Where("copies") == "f.yaml:3: rows.1.copies");
  CHECK(table.data.Where("type") == "f.yaml:5: data.type");
}

TEST_CASE("Lists that are given replace the defaults") {
  TableOptions defaults;
  defaults.rows.resize(3);
  CHECK(ReadOptions(ConfigFromYaml("rows: []\n"), defaults).rows.empty());
  CHECK(ReadOptions(Config(), defaults).rows.size() == 3);
}

TEST_CASE("Mistakes within lists and maps name their place") {
  const auto [yaml, message] = GENERATE(table<std::string, std::string>({
      {"rows: {a: 1}", "f.yaml:1: rows: expected a list, got a map"},
      {"rows:\n- {name: a, problems: 0}\n", "f.yaml:2: rows.0.problems: expected an integer of at least 1, got '0'"},
      {"rows:\n- [a, b]\n", "f.yaml:2: rows.0: expected a map of options, got a list"},
      {"rows: [{name: a}, {name: bad}]", "f.yaml:1: rows.1: no row is named bad"},
      {"data: 3", "f.yaml:1: data: expected a map of options, got '3'"},
  }));
  CHECK_THROWS_WITH(Read<TableOptions>(yaml), message);
}

TEST_CASE("A sub-document that became its own keeps its path and --set in messages") {
  Config config = ConfigFromYaml("rows:\n- name: a\n  noise: unifrom\n", "f.yaml");
  const auto own = ReadOptions<TableOptions>(config).rows[0].own;
  CHECK_THROWS_WITH(ReadOptions<NoiseOptions>(own), Contains("f.yaml:3: rows.0.noise: expected one of"));
  SetYaml(&config, "rows.0.noise=none");
  SetYaml(&config, "rows.0.wide=3");
  const auto set = ReadOptions<TableOptions>(config).rows[0].own;
  CHECK_THROWS_WITH(ReadOptions<NoiseOptions>(set),
                    "--set rows.0.wide=3: unknown key 'rows.0.wide'; did you mean "
                    "'noise'?");
}

TEST_CASE("Lists and documents that are written read back equal") {
  const auto table =
      Read<TableOptions>("rows: [{name: a}, {name: b, problems: 3, deep: {list: [1, {x: y}]}}]\ndata: {type: line}\n");
  const std::string yaml = WriteYaml(table);
  CAPTURE(yaml);
  CHECK(WriteYaml(Read<TableOptions>(yaml)) == yaml);
  CHECK_THAT(yaml, Contains("problems: 3\n    deep:\n"));
}

TEST_CASE("An optional value can be taken back") {
  Row row;
  row.problems = 5;
  CHECK(ReadOptions(ConfigFromYaml("name: a"), row).problems == 5);
  CHECK_FALSE(ReadOptions(ConfigFromYaml("problems: ~"), row).problems);
  CHECK_THROWS_WITH(ReadOptions(ConfigFromYaml("problems: x", "f.yaml"), row),
                    "f.yaml:1: problems: expected an integer of at least 1, got 'x'");
}

TEST_CASE("CheckOptions holds C++ callers to the limits of the file") {
  NoiseOptions options;
  CHECK_NOTHROW(CheckOptions(options));
  options.sigma = 0.0;
  CHECK_THROWS_WITH(CheckOptions(options), "sigma: expected a number above 0, got '0'");
  options.sigma = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(CheckOptions(options), Error);
  options.noise = Noise::kNone;  // sigma does not act
  CHECK_NOTHROW(CheckOptions(options));
  options.other = Noise::kNone;
  CHECK_THROWS_WITH(CheckOptions(options), Contains("other: expected one of gaussian, uniform, got 'none'"));
  TableOptions table;
  table.rows.resize(2);
  table.rows[1].problems = 0;
  CHECK_THROWS_WITH(CheckOptions(table), "rows.1.problems: expected an integer of at least 1, got '0'");
}

TEST_CASE("Options describe themselves") {
  const auto described = DescribeOptions<NoiseOptions>();
  REQUIRE(described.size() == 4);
  CHECK(described[0].key == "noise");
  CHECK(described[0].type == "one of gaussian, uniform, none");
  CHECK(described[0].default_value == "gaussian");
  CHECK(described[0].help == "how inliers scatter");
  CHECK(described[2].type == "a list of gaussian, uniform, none");
  CHECK(described[2].default_value == "[none]");
  CHECK(described[3].type == "a number above 0");
  CHECK(described[3].when == "noise: gaussian");
  const auto table = DescribeOptions<TableOptions>();
  CHECK(table[0].type == "a list of maps");
  REQUIRE(table[0].children.size() == 3);
  CHECK(table[0].children[1].type == "an integer of at least 1");
  CHECK(table[0].children[1].default_value.empty());
  CHECK(table[1].type == "a map");
}

TEST_CASE("Documents can be merged, changed and trimmed without touching each other") {
  const Config base = ConfigFromYaml("a: {x: 1, y: 2}\nb: 3\n", "base.yaml");
  const Config over = ConfigFromYaml("a:\n  y: 4\n", "over.yaml");
  const Config merged = base.MergedWith(over);
  CHECK(ToYaml(merged) == "a:\n  x: 1\n  y: 4\nb: 3\n");
  CHECK(merged.Where("a.y") == "over.yaml:2: a.y");
  CHECK(merged.Where("b") == "base.yaml:2: b");
  CHECK(ToYaml(base) == "a:\n  x: 1\n  y: 2\nb: 3\n");
  CHECK(ToYaml(base.Sub("a").With("x", over.Sub("a.y"))) == "x: 4\ny: 2\n");
  CHECK(ToYaml(base.Sub("a").With("z", over.Sub("a"))) == "x: 1\ny: 2\nz:\n  y: 4\n");
  CHECK(ToYaml(base.Without({"a", "none"})) == "b: 3\n");
  CHECK(base.Sub("a").Without({"x"}).Where("y") == "base.yaml:1: a.y");
  CHECK(base.Keys() == std::vector<std::string>{"a", "b"});
  CHECK(base.Sub("b").Keys().empty());
}

}  // namespace diffsac
