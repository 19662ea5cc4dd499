#include "diffsac/core/parallel.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/core/status.h"

namespace diffsac {

TEST_CASE("ParallelFor gives the same for any number of threads") {
  const auto draw = [](int threads) {
    const Rng rng(1);
    std::vector<double> values(5000);
    ParallelFor(5000, threads, [&](std::int64_t i) {
      Rng own = rng.Fork("item", static_cast<std::uint64_t>(i));
      values[static_cast<std::size_t>(i)] = own.Normal();
    });
    return values;
  };
  const auto alone = draw(1);
  CHECK(draw(2) == alone);
  CHECK(draw(8) == alone);
  CHECK(draw(0) == alone);
}

TEST_CASE("ParallelFor visits each index once, nested and empty too") {
  std::vector<std::atomic<int>> visits(600);
  ParallelFor(20, 4, [&](std::int64_t i) {
    ParallelFor(30, 2, [&](std::int64_t j) { ++visits[static_cast<std::size_t>(i * 30 + j)]; });
  });
  for (const auto& count : visits) CHECK(count == 1);
  ParallelFor(0, 4, [](std::int64_t) { FAIL("no index to visit"); });
}

TEST_CASE("ParallelFor rethrows an exception of the body with its type") {
  const int threads = GENERATE(1, 2, 8);
  const auto run = [&] {
    ParallelFor(1000, threads, [](std::int64_t i) {
      if (i == 417) throw Error("item 417");
    });
  };
  CHECK_THROWS_AS(run(), Error);
  CHECK_THROWS_WITH(run(), "item 417");
  // The next loop is not affected.
  std::atomic<int> count = 0;
  ParallelFor(100, threads, [&](std::int64_t) { ++count; });
  CHECK(count == 100);
}

TEST_CASE("HardwareThreads is positive") { CHECK(HardwareThreads() >= 1); }

}  // namespace diffsac
