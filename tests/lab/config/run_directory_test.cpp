#include "lab/config/run_directory.h"

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <optional>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "diffsac/core/version.h"
#include "lab/config/yaml.h"
#include "lab/files/files.h"
#include "lab/options/options.h"

namespace diffsac {

using Catch::Contains;

TEST_CASE("RunDirectory records where a result comes from and stays readable YAML") {
  const TemporaryFolder folder;
  const RunDirectory run(folder.File("a/run"), "diffsac_train", "model:\n  width: 64\n", 42);
  const std::string text = ReadFile(run.File("config.yaml"));
  CHECK_THAT(text, Contains("# program: diffsac_train\n") && Contains("# seed: 42\n") && Contains("# machine: ") &&
                       Contains("# date: 20") && Contains("# libraries: LibTorch 2.") && Contains(", OpenCV 4.") &&
                       Contains(", Eigen 3.") && Contains("# git revision: " + GitRevision() + "\n"));
  CHECK(ToYaml(ConfigFromFile(run.File("config.yaml"))) == "model:\n  width: 64\n");
  CHECK(std::filesystem::path(run.File("x.csv")).parent_path() == run.path());
}

TEST_CASE("a run's folder says what program it is of") {
  const TemporaryFolder folder;
  const RunDirectory run(folder.File("run"), "diffsac_eval", "name: x\n", 1);
  CHECK(ProgramOfRun(run.path()) == "diffsac_eval");
  CHECK(ProgramOfRun(folder.path()).empty());
  WriteFileAtomically(folder.File("config.yaml"), "name: by hand\n");
  CHECK(ProgramOfRun(folder.path()).empty());
}

TEST_CASE("RunDirectory below a file is a clear error") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("file"), "");
  CHECK_THROWS_AS(RunDirectory(folder.File("file/run"), "p", "", 0), Error);
}

TEST_CASE("Version and machine are one line each") {
  CHECK_THAT(VersionText("diffsac_eval"),
             Catch::StartsWith("diffsac_eval " + std::string(kVersion) + " (git ") && Contains(GitRevision() + ")"));
  CHECK_FALSE(GitRevision().empty());
  const std::string machine = MachineText();
  CHECK_THAT(machine, Contains("core") && Contains("GiB"));
  CHECK(machine.find('\n') == std::string::npos);
}

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
