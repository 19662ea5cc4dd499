
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
#include "lab/files/files.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

std::string SoundFile(const TemporaryFolder& folder) {
  const std::string path = folder / "sound.h5";
  const std::lock_guard lock(Hdf5Mutex());
  {
    const H5::H5File file(path, H5F_ACC_TRUNC);
    const std::vector<double> values(36, 0.5);
    for (const char* name : {"a", "b"}) WriteNumbers(file, name, values.data(), {12, 3});
  }
  return ReadFile(path);
}

/// The message of reading all data sets; empty where they can be read.
std::string ErrorOfReading(const std::string& path) {
  return ErrorOf([&] {
    const std::lock_guard lock(Hdf5Mutex());
    std::string place = path;
    WithClearErrors(place, [&] {
      const H5::H5File file = OpenHdf5(path);
      for (hsize_t i = 0; i < file.getNumObjs(); ++i) {
        place = path + ": " + file.getObjnameByIdx(i);
        ReadNumbers(file.openDataSet(file.getObjnameByIdx(i)), place);
      }
    });
  });
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

TEST_CASE("values that no file holds are refused") {
  TemporaryFolder folder;
  const std::string path = folder / "claims.h5";
  const auto error = [&](hsize_t rows, hsize_t chunk_rows, const std::string& external) {
    {
      H5::H5File file(path, H5F_ACC_TRUNC);
      const hsize_t shape[2] = {rows, 2}, chunk[2] = {chunk_rows, 2}, most[2] = {H5S_UNLIMITED, 2};
      H5::DSetCreatPropList properties;
      if (external.empty())
        properties.setChunk(2, chunk);
      else
        properties.setExternal(external.c_str(), 0, H5F_UNLIMITED);
      file.createDataSet("set", H5::PredType::NATIVE_DOUBLE,
                         external.empty() ? H5::DataSpace(2, shape, most) : H5::DataSpace(2, shape), properties);
    }
    return ErrorOfReading(path);
  };
  CHECK(Has(error(hsize_t{1} << 60, 64, ""), "claims.h5: set: damaged, or too large"));
  CHECK(Has(error(hsize_t{1} << 27, 64, ""), "claims more values than its file can hold"));
  CHECK(Has(error(4, hsize_t{1} << 26, ""), "claims chunks larger than its file can hold"));
  CHECK(Has(error(4, hsize_t{1} << 23, ""), "claims chunks larger than its file can hold"));
  CHECK(Has(error(4, 64, "/dev/zero"), "its values lie in other files"));
  // Values that were never written are zeros, as many as a real file may hold.
  CHECK(error(1000, 64, "").empty());
  // Equal values, which deflate makes a thousandth of.
  {
    H5::H5File file(path, H5F_ACC_TRUNC);
    const hsize_t shape[2] = {1 << 20, 2}, chunk[2] = {1 << 18, 2};
    H5::DSetCreatPropList properties;
    properties.setChunk(2, chunk);
    properties.setDeflate(9);
    const std::vector<double> values(std::size_t{2} << 20, 1.0);
    file.createDataSet("set", H5::PredType::NATIVE_DOUBLE, H5::DataSpace(2, shape), properties)
        .write(values.data(), H5::PredType::NATIVE_DOUBLE);
  }
  CHECK(ErrorOfReading(path).empty());
}

TEST_CASE("links into other files do not open") {
  constexpr unsigned char kHead[] = {
      0x89, 0x48, 0x44, 0x46, 0x0d, 0x0a, 0x1a, 0x0a, 0x03, 0x08, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
      0x00, 0x00, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xc3, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
      0x30, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x06, 0x1a, 0x61, 0x37, 0x4f, 0x48, 0x44, 0x52, 0x02, 0x20,
      0x3e, 0xba, 0x03, 0x6b, 0x3e, 0xba, 0x03, 0x6b, 0x3e, 0xba, 0x03, 0x6b, 0x3e, 0xba, 0x03, 0x6b, 0x78, 0x02,
      0x12, 0x00, 0x00, 0x00, 0x00, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,
      0xff, 0xff, 0xff, 0x0a, 0x02, 0x00, 0x01, 0x00, 0x00, 0x06, 0x1c, 0x00, 0x00, 0x01, 0x08, 0x40, 0x09};
  std::string bytes(reinterpret_cast<const char*>(kHead), sizeof kHead);
  bytes += "im_0-im_1";
  bytes += std::string("\x0d\0\0/dev/zero\0/\0\0\x38", 18);
  bytes.resize(191, '\0');
  bytes += "\x4f\xcf\xc9\x97";
  TemporaryFolder folder;
  WriteRaw(folder / "link.h5", bytes);
  const std::string error = ErrorOfReading(folder / "link.h5");
  CHECK(Has(error, "link.h5: im_0-im_1: "));
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
