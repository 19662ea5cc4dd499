#include "diffsac/core/status.h"

#include <catch2/catch.hpp>

namespace diffsac {

TEST_CASE("Status names are those of the output files") {
  CHECK(ToString(Status::kOk) == "ok");
  CHECK(ToString(Status::kTooFewPoints) == "too_few_points");
  CHECK(ToString(Status::kDegenerate) == "degenerate");
  CHECK(ToString(Status::kNoModel) == "no_model");
}

}  // namespace diffsac
