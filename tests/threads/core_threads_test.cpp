// Parallel loops, logging, progress, prefetcher and caches under contention. Their results are tested beside them: here
// the thread sanitizer looks at how they share memory.

#include <atomic>
#include <catch2/catch.hpp>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/temporary_folder.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/lru_cache.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "lab/config/progress.h"
#include "lab/files/files.h"
#include "lab/train/prefetcher.h"

namespace diffsac {
namespace {

constexpr int kThreads = 4;

/// More threads than the machine may have cores.
template <class Body>
void OnThreads(int count, const Body& body) {
  std::vector<std::thread> threads;
  for (int i = 0; i < count; ++i) threads.emplace_back([&body, i] { body(i); });
  for (std::thread& thread : threads) thread.join();
}

}  // namespace

TEST_CASE("loops see what came before them, and what comes after sees them") {
  std::vector<int> values(10000);
  for (int round = 0; round < 50; ++round) {
    const auto count = static_cast<std::int64_t>(values.size());
    ParallelFor(count, 0, [&](std::int64_t i) { values[i] += static_cast<int>(i % 3); });
  }
  CHECK(std::accumulate(values.begin(), values.end(), 0) == 50 * 9999);
}

TEST_CASE("loops within loops, and from several threads at once") {
  std::vector<std::vector<int>> sums(kThreads, std::vector<int>(20));
  OnThreads(kThreads, [&](int thread) {
    ParallelFor(20, 0, [&](std::int64_t i) {
      std::vector<int> inner(100);
      ParallelFor(100, 0, [&](std::int64_t j) { inner[j] = static_cast<int>(j); });
      sums[thread][i] = std::accumulate(inner.begin(), inner.end(), 0);
    });
  });
  for (const auto& sum : sums) CHECK(sum == std::vector<int>(20, 4950));
}

TEST_CASE("what loops throw arrives, and what the others wrote is there") {
  for (int round = 0; round < 30; ++round) {
    std::vector<int> done(2000);
    CHECK_THROWS_AS(ParallelFor(2000, 0,
                                [&](std::int64_t i) {
                                  if (i == 700) throw Error("at 700");
                                  done[i] = 1;
                                }),
                    Error);
    CHECK(std::accumulate(done.begin(), done.end(), 0) < 2000);
  }
}

TEST_CASE("log lines and progress of many threads") {
  const TemporaryFolder folder;
  InitLogging(folder.File("log.txt"), true);
  constexpr int kLines = 200;
  {
    Progress progress("work", kThreads * kLines);
    OnThreads(kThreads, [&](int thread) {
      for (int i = 0; i < kLines; ++i) {
        LogInfo("thread " + std::to_string(thread) + " line " + std::to_string(i));
        progress.Advance(1, i % 7 == 0 ? "note " + std::to_string(thread) : "");
      }
    });
    progress.Finish();
  }
  const std::string log = ReadFile(folder.File("log.txt"));
  int lines = 0;
  for (std::size_t at = 0; (at = log.find("] thread ", at)) != std::string::npos; ++at) ++lines;
  CHECK(lines == kThreads * kLines);
  InitLogging("", true);
}

TEST_CASE("a prefetcher's items, its counters, an error and an early end") {
  for (int round = 0; round < 20; ++round) {
    Prefetcher<std::vector<int>> items(
        [](std::uint64_t index) { return std::vector<int>(50, static_cast<int>(index)); }, kThreads, 6);
    for (int i = 0; i < 60; ++i) {
      CHECK(items.Next() == std::vector<int>(50, i));
      CHECK(items.wait_seconds() >= 0.0);
    }
    // The destructor drops those in the making.
  }
  Prefetcher<int> failing(
      [](std::uint64_t index) {
        if (index == 9) throw Error("at 9");
        return static_cast<int>(index);
      },
      kThreads, 4);
  for (int i = 0; i < 9; ++i) CHECK(failing.Next() == i);
  CHECK_THROWS_AS(failing.Next(), Error);
}

TEST_CASE("recently used files, asked for by many threads") {
  struct Text {
    explicit Text(const std::string& path) : text(ReadFile(path)) {}
    std::string text;
  };
  const TemporaryFolder folder;
  for (int i = 0; i < 6; ++i) WriteFileAtomically(folder.File(std::to_string(i)), std::string(100, 'a' + i));
  LruCache<Text> files(3);
  std::atomic<int> wrong{0};
  OnThreads(kThreads, [&](int thread) {
    Rng rng = Rng(1).Fork("thread", thread);
    for (int i = 0; i < 300; ++i) {
      const int which = static_cast<int>(rng.Below(6));
      wrong += files.Get(folder.File(std::to_string(which)))->text != std::string(100, 'a' + which);
    }
  });
  CHECK(wrong == 0);
}

TEST_CASE("files written into one folder by many threads are whole") {
  const TemporaryFolder folder;
  OnThreads(kThreads, [&](int thread) {
    for (int i = 0; i < 20; ++i) {
      WriteFileAtomically(folder.File("shared"), std::string(1000, 'a' + thread));
      const std::string content = ReadFile(folder.File("shared"));
      if (content != std::string(1000, content.at(0))) throw std::logic_error("half a file");
    }
  });
  CHECK(folder.NumEntries() == 1);
}

}  // namespace diffsac
