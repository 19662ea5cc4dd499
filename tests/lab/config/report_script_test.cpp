#include "lab/config/report_script.h"

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "core/temporary_folder.h"
#include "lab/files/files.h"

namespace diffsac {

TEST_CASE("a script that is not there or fails does not end a run, one that cannot write does") {
  const TemporaryFolder folder;
  CHECK_FALSE(RunReportScript("no_such_script.py", {folder.path()}));
  CHECK_FALSE(WriteReport(folder.path()));  // It has no run.
  if (!HasReportPython()) return;
  std::filesystem::create_directory(folder.File("report.html"));
  CHECK_THROWS_WITH(RunReportScript("training_report.py", {folder.path()}),
                    Catch::Contains("cannot write " + folder.File("report.html")));
}

TEST_CASE("a script that runs can be stopped") {
  const TemporaryFolder folder;
  ReportScript script;
  CHECK_FALSE(script.Runs());
  CHECK_FALSE(script.Wait());
  script.Start("training_report.py", {"--running", folder.path()});
  CHECK(script.Runs() == HasReportPython());
  script.Stop();
  CHECK_FALSE(script.Runs());
}

TEST_CASE("half a picture of a report that was killed goes with the next report") {
  if (!HasReportPython()) return;
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    std::ofstream(TemporaryBeside(folder.File("curve.png"))) << "half" << std::flush;
    ::_exit(0);
  }
  ::waitpid(child, nullptr, 0);
  CHECK(folder.NumEntries() == 1);
  WriteReport(folder.path());
  CHECK(folder.NumEntries() == 0);
}

}  // namespace diffsac
