#include "lab/config/run_lock.h"

#include <catch2/catch.hpp>

#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

bool CanLock(const std::string& folder) {
  try {
    const RunLock lock(folder);
    return true;
  } catch (const Error& error) {
    CHECK_THAT(error.what(), Catch::Contains(folder) && Catch::Contains("another process is writing there"));
    return false;
  }
}

TEST_CASE("a run's folder is one run's at a time, and given back when it ends") {
  const TemporaryFolder folder;
  const std::string run = folder.File("runs/a");
  {
    const RunLock lock(run);
    CHECK_FALSE(CanLock(run));
    CHECK(CanLock(folder.File("runs/b")));
  }
  CHECK(CanLock(run));
  CHECK(std::filesystem::is_empty(run));
}

TEST_CASE("a killed process gives its run's folder back") {
  const TemporaryFolder folder;
  const std::string run = folder.File("run");
  int held[2];
  REQUIRE(::pipe(held) == 0);
  const pid_t process = ::fork();
  if (process == 0) {
    const RunLock lock(run);
    const char byte = 1;
    if (::write(held[1], &byte, 1) == 1) ::pause();
    ::_exit(1);
  }
  char byte = 0;
  REQUIRE(::read(held[0], &byte, 1) == 1);
  CHECK_FALSE(CanLock(run));
  REQUIRE(::kill(process, SIGKILL) == 0);
  REQUIRE(::waitpid(process, nullptr, 0) == process);
  CHECK(CanLock(run));
  ::close(held[0]);
  ::close(held[1]);
}

TEST_CASE("what cannot be a run's folder is named") {
  const TemporaryFolder folder;
  std::ofstream(folder.File("file")) << "x";
  CHECK_THROWS_WITH(RunLock(folder.File("file/run")), Catch::Contains(folder.File("file")));
}

}  // namespace
}  // namespace diffsac
