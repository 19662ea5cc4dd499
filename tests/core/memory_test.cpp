#include "diffsac/core/memory.h"

#include <catch2/catch.hpp>
#include <vector>

#ifdef __GLIBC__
#include <malloc.h>

namespace diffsac {
namespace {

TEST_CASE("a program keeps the memory of large buffers that it frees") {
  KeepFreedMemory();
  constexpr std::size_t kBytes = 64u << 20;
  { const std::vector<char> buffer(kBytes, 1); }
  const auto state = mallinfo2();
  CHECK(state.hblkhd == 0);  // nothing was mapped by itself
  CHECK(state.fordblks >= kBytes);
}

}  // namespace
}  // namespace diffsac
#endif
