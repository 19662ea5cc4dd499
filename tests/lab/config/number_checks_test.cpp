#include "lab/config/program.h"

#include <catch2/catch.hpp>

namespace diffsac {
namespace {

using Catch::Contains;

/// What a program would say of this; empty where the number is good.
std::string Said(const CLI::Validator& check, const std::string& text) {
  CLI::App app;
  double value = 0.0;
  app.add_option("--number", value)->check(check);
  try {
    app.parse("--number=" + text);
  } catch (const CLI::ParseError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("numbers out of range are refused in few words, with the range") {
  CHECK(Said(NumberAbove(0), "0.5").empty());
  CHECK(Said(NumberFrom(0), "0").empty());
  CHECK(Said(NumberWithin(0, 1024), "1024").empty());
  CHECK_THAT(Said(NumberAbove(0), "0"), Contains("--number: expected a number above 0, found '0'"));
  CHECK_THAT(Said(NumberFrom(0), "-1e300"), Contains("expected a number from 0 on, found '-1e300'"));
  CHECK_THAT(Said(NumberWithin(0, 1024), "1025"), Contains("expected a number from 0 to 1024, found '1025'"));
  CHECK_THAT(Said(NumberAbove(0.5), "many"), Contains("expected a number above 0.5, found 'many'"));
  CHECK_THAT(Said(NumberAbove(0), "nan"), Contains("expected"));
  for (const auto& check : {NumberAbove(0), NumberFrom(0), NumberWithin(0, 1)}) CHECK(Said(check, "-7").size() < 80);
}

}  // namespace diffsac
