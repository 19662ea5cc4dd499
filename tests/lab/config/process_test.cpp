#include "lab/config/process.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace diffsac {

#ifdef __GLIBC__
TEST_CASE("a program keeps the memory of large buffers that it frees") {
  const auto before = mallinfo2();  // libraries may have mapped something when they were loaded
  KeepFreedMemory();
  constexpr std::size_t kBytes = 64u << 20;
  { const std::vector<char> buffer(kBytes, 1); }
  const auto state = mallinfo2();
  CHECK(state.hblkhd <= before.hblkhd);  // nothing was mapped by itself
  CHECK(state.fordblks >= kBytes);
}
#endif

#ifdef __linux__
TEST_CASE("the memory that can be had falls by what is taken") {
  const double before = AvailableMemoryMib();
  CHECK(before > 64.0);
  constexpr std::size_t kBytes = 1u << 30;
  const std::vector<char> buffer(kBytes, 1);
  CHECK(AvailableMemoryMib() < before - 512.0);
}
#endif

TEST_CASE("a waiting policy that is set stays, and nothing is started again") {
  ::setenv("OMP_WAIT_POLICY", "active", 1);
  char name[] = "nothing";
  char* arguments[] = {name, nullptr};
  WaitPassively(arguments);  // would run this test program again, for ever
  CHECK(std::string(std::getenv("OMP_WAIT_POLICY")) == "active");
  ::unsetenv("OMP_WAIT_POLICY");
}

}  // namespace diffsac
