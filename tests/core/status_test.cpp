#include "diffsac/core/status.h"

#include <catch2/catch.hpp>

namespace diffsac {

TEST_CASE("Status names are those of the output files") {
  CHECK(ToString(Status::kOk) == "ok");
  CHECK(ToString(Status::kTooFewPoints) == "too_few_points");
  CHECK(ToString(Status::kDegenerate) == "degenerate");
  CHECK(ToString(Status::kNoModel) == "no_model");
  CHECK(ToString(Status::kTooManyPoints) == "too_many_points");
}

TEST_CASE("regression: a stack trace of LibTorch's was printed in place of what went wrong") {
  CHECK(MessageOf(std::runtime_error("can't allocate memory\nframe #0: ...\nframe #1")) == "can't allocate memory");
  CHECK(MessageOf(Error("a.yaml:3: two\nlines")) == "a.yaml:3: two\nlines");
}

}  // namespace diffsac
