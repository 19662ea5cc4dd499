#include "lab/files/hdf5_input.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "core/errors.h"
#include "core/temporary_folder.h"
#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "lab/data/point_files.h"
#include "lab/data/synthetic.h"
#include "lab/data/write_point_sets.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/files/hdf5_output.h"

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

namespace {

void WriteMany(const std::string& path, int count) {
  Hdf5Output file(path, path);
  const std::vector<double> values(500, 1.5);
  for (int i = 0; i < count; ++i) file.Put("set" + std::to_string(i), values.data(), {250, 2});
  file.Close();
}

/// What a process of its own, whose files hold at most so many bytes, says and how it ends.
std::string ErrorWithin(rlim_t most_bytes, const std::string& path, const std::string& note, int* status) {
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    std::string text = "none";
    const rlimit limit{most_bytes, RLIM_INFINITY};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    try {
      WriteMany(path, 200);
    } catch (const Error& error) {
      text = error.what();
    }
    const rlimit unlimited{RLIM_INFINITY, RLIM_INFINITY};
    ::setrlimit(RLIMIT_FSIZE, &unlimited);
    WriteFileAtomically(note, text);
    std::exit(0);  // With what the library does at the end of a program.
  }
  ::waitpid(child, status, 0);
  return ReadFile(note);
}

}  // namespace

TEST_CASE("a disk that fills is one error, wherever it does, and the library ends well") {
  const TemporaryFolder folder;
  const std::string path = folder.File("many.h5");
  for (const rlim_t most : {0, 100, 3000, 5000, 60000, 400000}) {
    CAPTURE(most);
    int status = -1;
    CHECK(ErrorWithin(most, path, folder.File("note"), &status) == "cannot write '" + path + "': File too large");
    CHECK(status == 0);
  }
}

TEST_CASE("a file that cannot be created names path and cause") {
  const TemporaryFolder folder;
  const std::string path = folder.File("none/a.h5");
  CHECK_THROWS_WITH(WriteMany(path, 1), "cannot write '" + path + "': No such file or directory");
}

TEST_CASE("the same content is the same file, whenever it is written") {
  const TemporaryFolder folder;
  WriteMany(folder.File("a.h5"), 30);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // Times in these files have seconds.
  WriteMany(folder.File("b.h5"), 30);
  CHECK(ReadFile(folder.File("a.h5")) == ReadFile(folder.File("b.h5")));
  const H5::H5File file(folder.File("a.h5"), H5F_ACC_RDONLY);
  CHECK(file.getNumObjs() == 30);
  double values[500] = {};
  file.openDataSet("set29").read(values, H5::PredType::NATIVE_DOUBLE);
  CHECK(values[499] == 1.5);
}

}  // namespace diffsac
