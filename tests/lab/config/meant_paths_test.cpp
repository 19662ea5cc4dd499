#include "lab/config/meant_paths.h"

#include <catch2/catch.hpp>

#include "lab/config/yaml.h"

namespace diffsac {
namespace {

TEST_CASE("an unknown key of a row names its path") {
  const auto rows = [] {
    return std::vector<PlacedConfig>{{"methods.a", ConfigFromYaml("{consensus: {most: 3}, least: 1}")},
                                     {"methods.b", ConfigFromYaml("{least: 1}")}};
  };
  const auto said = [&](const std::string& assignment) {
    return WithMeantPaths(Error("--set " + assignment + ": unknown key 'x'; did you mean 'seeds'?"),
                          {"seed=1", assignment}, rows);
  };
  CHECK(said("consensus.most=4") ==
        "--set consensus.most=4: unknown key 'x'; did you mean 'methods.a.consensus.most'?");
  CHECK(said("most=4") == "--set most=4: unknown key 'x'; did you mean 'methods.a.consensus.most'?");
  CHECK(said("least=4") == "--set least=4: unknown key 'x'; did you mean 'methods.a.least', 'methods.b.least'?");
  CHECK(said("other=4") == "--set other=4: unknown key 'x'; did you mean 'seeds'?");
  CHECK(WithMeantPaths(Error("a.yaml:3: unknown key 'x'"), {"most=4"}, rows) == "a.yaml:3: unknown key 'x'");
}

}  // namespace
}  // namespace diffsac
