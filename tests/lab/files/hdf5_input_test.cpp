#include "lab/files/hdf5_input.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "core/errors.h"
#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "lab/data/point_files.h"
#include "lab/data/synthetic.h"
#include "lab/data/write_point_sets.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

using testing::WritePointSets;

std::string SoundFile(const TemporaryFolder& folder) {
  SyntheticOptions options;
  options.num_points = {12, 12};
  const auto dataset = MakeSynthetic(Task::kPlane, options, 1);
  WritePointSets(folder / "sound.h5", {dataset->Get(0), dataset->Get(1)});
  return ReadFile(folder / "sound.h5");
}

/// The message of reading points; empty when there are points.
std::string ErrorOfReading(const std::string& path) {
  return ErrorOf([&] { ReadPointFile(path); });
}

void Open(const std::string& path) {
  const std::lock_guard lock(Hdf5Mutex());
  OpenHdf5(path);
}

volatile std::sig_atomic_t children = 0;

/// Counts the children that end while it lives.
class ChildCounter {
 public:
  ChildCounter() : before_(std::signal(SIGCHLD, [](int) { children = children + 1; })) { children = 0; }
  ~ChildCounter() { std::signal(SIGCHLD, before_); }
  int count() const { return children; }

 private:
  void (*before_)(int);
};

}  // namespace

TEST_CASE("bytes that crash the HDF5 library are one line that names the file") {
  const TemporaryFolder folder;
  const std::string sound = SoundFile(folder), path = folder / "damaged.h5";
  int crashes = 0;
  for (std::uint64_t i = 0; i < 400; ++i) {
    Rng rng = Rng(7).Fork("file", i);
    std::string bytes = sound;
    for (int changes = 0; changes < 4; ++changes) {
      const std::uint64_t word = rng.Below(2) == 0 ? ~std::uint64_t{0} : rng.Below(256);
      std::memcpy(bytes.data() + rng.Below(bytes.size() - 8), &word, 1 + rng.Below(8));
    }
    WriteRaw(path, bytes);
    const std::string error = ErrorOfReading(path);
    INFO(error);
    CHECK((error.empty() || error.find(path) != std::string::npos));
    if (error.find("crashes the HDF5 library") == std::string::npos) continue;
    CHECK(error.find('\n') == std::string::npos);
    ++crashes;
  }
  // The versions that are known to crash; later ones may have mended all of these.
  if (!H5_VERSION_GE(1, 12, 0)) CHECK(crashes > 0);
}

TEST_CASE("an HDF5 file is checked again only after it changed") {
  const TemporaryFolder folder;
  const std::string sound = SoundFile(folder), path = folder / "sound.h5";
  const ChildCounter counter;
  // Before a file is known by its times, the clock must have moved on.
  std::this_thread::sleep_for(std::chrono::milliseconds(3100));
  Open(path);
  CHECK(counter.count() == 1);
  Open(path);
  CHECK(counter.count() == 1);
  WriteRaw(path, sound);
  Open(path);
  CHECK(counter.count() == 2);
  Open(path);
  CHECK(counter.count() == 3);  // It could have changed within the clock's tick.
}

TEST_CASE("HDF5 files are checked while other threads allocate and throw") {
  const TemporaryFolder folder;
  SoundFile(folder);
  std::atomic<bool> stop{false};
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t)
    threads.emplace_back([&] {
      while (!stop) {
        try {
          throw std::runtime_error(std::string(1000, 'x'));
        } catch (const std::exception&) {
        }
      }
    });
  for (int i = 0; i < 50; ++i) CHECK_NOTHROW(Open(folder / "sound.h5"));
  stop = true;
  for (std::thread& thread : threads) thread.join();
}

}  // namespace diffsac
