#include "lab/files/hdf5_input.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "core/errors.h"
#include "core/temporary_folder.h"
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

}  // namespace

TEST_CASE("a corrupt HDF5 file is one named error") {
  const TemporaryFolder folder;
  const std::string sound = SoundFile(folder), path = folder / "damaged.h5";
  CHECK(ErrorOfReading(folder / "sound.h5").empty());
  std::vector<std::string> damaged = {"", "no HDF5 at all", std::string(sound.size(), '\0'), sound.substr(8)};
  for (const std::size_t kept : {8, 100, 500, 1000}) damaged.push_back(sound.substr(0, kept));
  damaged.push_back(sound.substr(0, sound.size() - 1));
  for (const std::string& bytes : damaged) {
    WriteRaw(path, bytes);
    const std::string error = ErrorOfReading(path);
    CAPTURE(bytes.size(), error);
    CHECK(error.find(path) != std::string::npos);
    CHECK(error.find('\n') == std::string::npos);
  }
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
