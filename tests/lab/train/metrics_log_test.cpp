#include "lab/train/metrics_log.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/temporary_folder.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;
using Columns = std::vector<std::string>;

const Columns kColumns = {"loss", "learning_rate", "mAA@0.5deg"};

}  // namespace

TEST_CASE("a resumed run keeps the rows up to its checkpoint, and changes nothing before it writes") {
  const TemporaryFolder folder;
  const std::string path = folder.File("metrics.csv");
  MetricsLog log(folder.path(), {"loss", "mAA"}, 0);
  log.Append(5, {0.5, kNotMeasured});
  log.Append(10, {0.25, 0.75});
  CHECK(ReadFile(path) == "iteration,loss,mAA\n5,0.5,\n10,0.25,0.75\n");
  MetricsLog resumed(folder.path(), {"loss", "mAA"}, 9);
  CHECK(ReadFile(path) == "iteration,loss,mAA\n5,0.5,\n10,0.25,0.75\n");
  resumed.Write();
  CHECK(ReadFile(path) == "iteration,loss,mAA\n5,0.5,\n");
}

TEST_CASE("a training's page is made beside it, and once more when it ends") {
  const TemporaryFolder folder;
  MetricsLog log(folder.path(), kColumns, 0);
  log.Append(5, {0.5, 0.1, 0.3});
  log.Tell(true);
  log.Tell(false);
  REQUIRE(std::filesystem::exists(folder.File("report.html")) == HasReportPython());
  if (HasReportPython())
    CHECK_THAT(ReadFile(folder.File("report.html")),
               !Contains("http-equiv=\"refresh\"") && Contains("To iteration 5."));
}

TEST_CASE("rows of other columns are not gone on with") {
  const TemporaryFolder folder;
  MetricsLog(folder.path(), {"loss", "mAA"}, 0).Append(5, {0.5, 0.7});
  CHECK_THROWS_WITH(MetricsLog(folder.path(), {"loss", "recall"}, 5),
                    Contains("metrics.csv: its columns are 'iteration,loss,mAA', expected 'iteration,loss,recall'"));
}

}  // namespace diffsac
