#include "lab/config/run_directory.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/temporary_folder.h"
#include "diffsac/core/options.h"
#include "diffsac/core/status.h"
#include "diffsac/core/version.h"
#include "lab/config/yaml.h"
#include "lab/files/files.h"

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

}  // namespace diffsac
