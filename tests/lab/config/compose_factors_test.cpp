#include "lab/config/compose_factors.h"

#include <catch2/catch.hpp>

#include "core/temporary_folder.h"
#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/config/compose.h"
#include "lab/config/yaml.h"

namespace diffsac {
namespace {

using Catch::Contains;

const char* kTwoFactors = R"(
settings:
  msac: {consensus: {score: msac, rounds: 1}}
factors_base: {type: ransac, copies: 1}
factors:
  score:
    msac: {use: msac}
    count: {consensus: {score: inlier_count}, copies: 2}
  draws:
    "100": {max_iterations: 100}
    "1000": {max_iterations: 1000, consensus: {rounds: 5}}
methods:
  oracle: {type: oracle}
  count_100: {label: Mine, use: msac}
  usac: {type: opencv}
)";

std::vector<Config> RowsOf(const std::string& text) {
  return ComposeExperiment(ConfigFromYaml(text, "x.yaml")).Sequence("methods");
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST_CASE("every combination of levels is a row, the last factor's changing fastest, before the other methods") {
  const std::vector<Config> rows = RowsOf(kTwoFactors);
  std::vector<std::string> names;
  for (const Config& row : rows) names.push_back(row.Text("name"));
  CHECK(names == std::vector<std::string>{"msac_100", "msac_1000", "count_100", "count_1000", "usac", "oracle"});
  CHECK(rows[1].Text("label") == "msac, 1000");
  CHECK(rows[1].Text("type") == "ransac");
  CHECK(rows[1].Text("max_iterations") == "1000");
  CHECK(rows[1].Text("consensus.score") == "msac");
}

TEST_CASE("later factors override earlier ones and all of them the base; a method of a row's name overrides them") {
  const std::vector<Config> rows = RowsOf(kTwoFactors);
  CHECK(rows[0].Text("copies") == "1");
  CHECK(rows[3].Text("copies") == "2");
  CHECK(rows[0].Text("consensus.rounds") == "1");  // The setting of the first factor's level,
  CHECK(rows[1].Text("consensus.rounds") == "5");  // overridden by the second factor's own key.
  CHECK(rows[2].Text("label") == "Mine");
  CHECK(rows[2].Text("consensus.score") == "msac");
  CHECK(rows[3].Text("label") == "count, 1000");
}

TEST_CASE("a composed document has the levels' names and composes to itself") {
  const Config once = ComposeExperiment(ConfigFromYaml(kTwoFactors, "x.yaml"));
  CHECK_THAT(ToYaml(once), Contains("score: [\"msac\", \"count\"]") && !Contains("factors_base"));
  CHECK(ToYaml(ComposeExperiment(once)) == ToYaml(once));
}

TEST_CASE("levels of several files come together, and `rows` chooses among the combinations") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("base.yaml"), kTwoFactors);
  WriteFileAtomically(folder.File("table.yaml"),
                      "include: base.yaml\nfactors: {score: {both: {use: msac, copies: 3}}}\n"
                      "rows: [both_1000, oracle]\nreference: msac_100\n");
  const Config composed = ComposeExperiment(ConfigFromFile(folder.File("table.yaml")));
  const std::vector<Config> rows = composed.Sequence("methods");
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].Text("name") == "both_1000");
  CHECK(rows[0].Text("copies") == "3");
  CHECK_FALSE(composed.Has("reference"));
}

TEST_CASE("mistakes in factors name file and line") {
  const auto fails = [](const std::string& from, const std::string& to, const std::string& message) {
    CHECK_THROWS_WITH(RowsOf(Replaced(kTwoFactors, from, to)), Contains(message));
  };
  fails("{use: msac}", "{use: masc}", "x.yaml:7: use: no setting is named 'masc'; did you mean 'msac'");
  fails("{use: msac}", "{label: M}", "x.yaml:7: factors.score.msac.label");
  fails("{use: msac}", "5", "x.yaml:7: factors.score.msac: expected a map");
  fails("{max_iterations: 100}", "{max_iterations: [1, 2]}",
        "x.yaml:10: factors.draws.100.max_iterations: expected one");
  fails("factors_base: {type", "factors_base: {name: a, type", "x.yaml:4: factors_base.name");
  CHECK_THROWS_WITH(RowsOf("factors: 3\n"), Contains("x.yaml:1: factors: expected a map"));
  CHECK_THROWS_WITH(RowsOf("factors: {score: {}}\n"), Contains("x.yaml:1: factors.score: expected a map of levels"));
  CHECK_THROWS_WITH(RowsOf("factors_base: {type: ransac}\nmethods: {a: {type: ransac}}\n"),
                    Contains("x.yaml:1: factors_base: acts only beside"));
  CHECK_THROWS_WITH(RowsOf("factors: {a: {b: {}}}\nmethods: [{type: ransac}]\n"), Contains("x.yaml:2: methods"));
  CHECK_THROWS_WITH(RowsOf("factors: {a: {x_y: {}, x: {}}, b: {z: {}, y_z: {}}}\n"), Contains("named 'x_y_z'"));
}

TEST_CASE("the combinations of no factor are one, without levels") {
  CHECK(CombinationsOf({}) == std::vector<std::vector<std::string>>{{}});
  CHECK(CombinationsOf({{"a", {"1", "2"}}, {"b", {"x"}}}) ==
        std::vector<std::vector<std::string>>{{"1", "x"}, {"2", "x"}});
  CHECK(FactorRowName({"msac", "uniform", "100"}) == "msac_uniform_100");
}

}  // namespace
}  // namespace diffsac
