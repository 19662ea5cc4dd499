#include "lab/config/program.h"

#include <catch2/catch.hpp>

namespace diffsac {
namespace {

TEST_CASE("a mistyped option names the nearest one") {
  CLI::App app;
  double focal = 0.0;
  app.add_option("--focal", focal);
  CLI::App* command = app.add_subcommand("pairs");
  command->add_option("--input", focal);
  const auto said = [&](std::vector<std::string> words) {
    std::reverse(words.begin(), words.end());
    CHECK_THROWS_AS(app.parse(words), CLI::ExtrasError);
    return NearestOptions(app);
  };
  CHECK(said({"--focl", "3"}) == "; did you mean '--focal'?");
  CHECK(said({"--focl=3"}) == "; did you mean '--focal'?");
  CHECK(said({"word"}).empty());
  CHECK(said({"pairs", "--imput", "3"}) == "; did you mean '--input'?");
}

}  // namespace
}  // namespace diffsac
