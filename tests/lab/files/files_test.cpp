#include "lab/files/files.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"

namespace diffsac {

using Catch::Contains;

TEST_CASE("WriteFileAtomically writes and replaces, leaving nothing else behind") {
  const TemporaryFolder folder;
  const std::string file = folder.File("a.txt"), binary("x\0y\n", 4);
  WriteFileAtomically(file, "old");
  WriteFileAtomically(file, binary);
  CHECK(ReadFile(file) == binary);
  WriteFileAtomically(file, "");
  CHECK(ReadFile(file).empty());
  CHECK(folder.NumEntries() == 1);
}

TEST_CASE("A text's encoding is told, and a byte order mark is passed over") {
  const TemporaryFolder folder;
  const std::string file = folder.File("a.csv");
  const auto read = [&](const std::string& text) {
    WriteFileAtomically(file, text);
    return ReadTextFile(file);
  };
  CHECK(read("\xEF\xBB\xBFx,y\r\n1,2\r\n") == "x,y\r\n1,2\r\n");
  CHECK(read("1 2\r3 4\r") == "1 2\n3 4\n");
  CHECK(read("").empty());
  CHECK_THROWS_WITH(read(std::string("\xFF\xFEx\0", 4)), Contains("UTF-16LE; expected UTF-8: iconv -f UTF-16 "));
  CHECK_THROWS_WITH(read(std::string("\xFE\xFF\0x", 4)), Contains("UTF-16BE"));
  CHECK_THROWS_WITH(read(std::string("1\0,\0", 4)), Contains("UTF-16LE"));
  CHECK_THROWS_WITH(read(std::string("\xFF\xFE\0\0x\0\0\0", 8)), Contains("UTF-32LE"));
  CHECK_THROWS_WITH(read(std::string("1,2\n3,\0\0\0", 9)), file + ":2: a zero byte: damaged, or no text");
  CHECK_THROWS_WITH(ReadTextFile(folder.path()), Contains("cannot read"));
}

TEST_CASE("No output is an input, however it is spelt or linked") {
  namespace fs = std::filesystem;
  const TemporaryFolder folder;
  const std::string photo = folder.File("a.jpg");
  WriteFileAtomically(photo, "photo");
  fs::create_directories(folder.File("sub"));
  fs::create_symlink("../a.jpg", folder.File("sub/soft.jpg"));
  fs::create_hard_link(photo, folder.File("sub/hard.jpg"));
  for (const char* name : {"a.jpg", "sub/../a.jpg", "./a.jpg", "sub/soft.jpg", "sub/hard.jpg"}) {
    CHECK_THROWS_WITH(RefuseInputsAsOutputs({"", folder.File(name)}, {"", photo}),
                      "'" + folder.File(name) + "' would be written over an input, '" + photo + "'");
    CHECK_THROWS_WITH(RefuseInputsAsOutputs({folder.File(name)}, {folder.path()}), Contains("a file of an input"));
  }
  CHECK_THROWS_WITH(RefuseInputsAsOutputs({folder.File("new"), folder.File("sub/../new")}, {}),
                    Contains("are one file, and both would be written"));
  CHECK_NOTHROW(RefuseInputsAsOutputs({folder.File("new"), folder.File("sub/new"), "/dev/null"},
                                      {photo, folder.path(), "/dev/null"}));
}

TEST_CASE("A writer gets a temporary path with the same extension") {
  const TemporaryFolder folder;
  const std::string file = folder.File("model.safetensors");
  WriteFileAtomically(file, [&](const std::string& temporary) {
    CHECK(temporary != file);
    CHECK(std::filesystem::path(temporary).extension() == ".safetensors");
    std::ofstream(temporary) << "weights";
  });
  CHECK(ReadFile(file) == "weights");
}

TEST_CASE("A writer that fails leaves the old file and no temporary one") {
  const TemporaryFolder folder;
  const std::string file = folder.File("model.safetensors");
  WriteFileAtomically(file, "old");
  const auto fail = [](const std::string& temporary) {
    std::ofstream(temporary) << "half";
    throw std::runtime_error("broken\nbacktrace");
  };
  CHECK_THROWS_WITH(WriteFileAtomically(file, fail), "cannot write '" + file + "': broken");
  CHECK_THROWS_AS(WriteFileAtomically(file, fail), Error);
  CHECK(ReadFile(file) == "old");
  CHECK(folder.NumEntries() == 1);
}

TEST_CASE("A link is written through") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("real"), "old");
  std::filesystem::create_symlink("real", folder.File("link"));
  WriteFileAtomically(folder.File("link"), "new");
  CHECK(std::filesystem::is_symlink(folder.File("link")));
  CHECK(ReadFile(folder.File("real")) == "new");
}

TEST_CASE("Writing where it cannot be done names path and cause") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("file"), "x");
  const std::string below = folder.File("file/below");
  CHECK_THROWS_WITH(WriteFileAtomically(below, "x"), "cannot write '" + below + "': Not a directory");
  CHECK_THROWS_WITH(MakeWritableFolder(below), Contains(below) && Contains("Not a directory"));
  CHECK_THROWS_WITH(MakeWritableFolder(folder.File("file")), Contains(folder.File("file")));
  CHECK_THROWS_WITH(WriteFileAtomically(folder.path(), "x"), Contains("it is a folder"));
  const std::string absent = folder.File("none/file");
  CHECK_THROWS_WITH(WriteFileAtomically(absent, "x"), Contains(absent) && Contains("No such file"));
  if (std::filesystem::exists("/dev/full")) {
    CHECK_THROWS_WITH(WriteFileAtomically("/dev/full", "x"), "cannot write '/dev/full': No space left on device");
  }
}

// A process that is no more: this one's child, waited for.
pid_t DeadProcess() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ::waitpid(child, nullptr, 0);
  return child;
}

// What a process that was killed in WriteFileAtomically leaves: it is killed by the writer it calls.
void BeKilledWriting(const std::string& file) {
  const pid_t child = ::fork();
  if (child == 0)
    WriteFileAtomically(file, [](const std::string& temporary) {
      std::ofstream(temporary) << "half" << std::flush;
      ::raise(SIGKILL);
    });
  ::waitpid(child, nullptr, 0);
}

TEST_CASE("What killed processes left goes with the next first file, what others write stays") {
  const TemporaryFolder other;
  BeKilledWriting(other.File("a.txt"));
  BeKilledWriting(other.File("a.txt"));
  CHECK(other.NumEntries() == 1);  // The second removed what the first left.
  const std::string dead = std::to_string(DeadProcess()), mine = std::to_string(::getpid());
  const std::string kept[] = {".b.tmp-" + mine + "-0-elsewhere.txt", ".b.tmp-" + dead + "-0-elsewhere.txt", ".hidden",
                              ".b.tmp-x", "b.tmp-" + dead + "-0-elsewhere.txt"};
  for (const std::string& name : kept) std::ofstream(other.File(name)) << "x";
  const std::string old = ".c.tmp-" + dead + "-0-elsewhere.txt";
  std::ofstream(other.File(old)) << "x";
  std::filesystem::last_write_time(other.File(old),
                                   std::filesystem::file_time_type::clock::now() - std::chrono::hours(25));
  WriteFileAtomically(other.File("a.txt"), "new");
  for (const std::string& name : kept) {
    INFO(name);
    CHECK(std::filesystem::exists(other.File(name)));
  }
  CHECK_FALSE(std::filesystem::exists(other.File(old)));
  CHECK(other.NumEntries() == 6);
}

TEST_CASE("What a process left that has ended but was not waited for goes as well") {
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    std::ofstream(TemporaryBeside(folder.File("a.txt"))) << "half" << std::flush;
    ::_exit(0);
  }
  siginfo_t state{};
  REQUIRE(::waitid(P_PID, static_cast<id_t>(child), &state, WEXITED | WNOWAIT) == 0);
  CHECK(folder.NumEntries() == 1);
  RemoveLeftOver(folder.path());
  CHECK(folder.NumEntries() == 0);
  ::waitpid(child, nullptr, 0);
}

TEST_CASE("RemoveFile removes what is there, and names what it cannot remove") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("a"), "x");
  RemoveFile(folder.File("a"));
  RemoveFile(folder.File("a"));
  RemoveFile(folder.File("none/a"));
  CHECK(folder.NumEntries() == 0);
  CHECK_THROWS_WITH(RemoveFile(folder.path()), Contains("cannot remove '" + folder.path()));
}

TEST_CASE("ReadFile names path and cause") {
  const TemporaryFolder folder;
  const std::string absent = folder.File("none");
  CHECK_THROWS_WITH(ReadFile(absent), "cannot read '" + absent + "': No such file or directory");
  CHECK_THROWS_WITH(ReadFile(folder.path()), Contains("Is a directory"));
}

TEST_CASE("MakeWritableFolder creates parents and leaves them empty") {
  const TemporaryFolder folder;
  MakeWritableFolder(folder.File("a/b/c"));
  MakeWritableFolder(folder.File("a/b/c"));
  CHECK(std::filesystem::is_directory(folder.File("a/b/c")));
  CHECK(std::filesystem::is_empty(folder.File("a/b/c")));
}

}  // namespace diffsac
