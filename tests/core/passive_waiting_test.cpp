#include "diffsac/core/passive_waiting.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>

TEST_CASE("a waiting policy that is set stays, and nothing is started again") {
  ::setenv("OMP_WAIT_POLICY", "active", 1);
  char name[] = "nothing";
  char* arguments[] = {name, nullptr};
  diffsac::WaitPassively(arguments);  // would run this test program again, for ever
  CHECK(std::string(std::getenv("OMP_WAIT_POLICY")) == "active");
  ::unsetenv("OMP_WAIT_POLICY");
}
