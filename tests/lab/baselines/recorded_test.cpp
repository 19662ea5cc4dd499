// Rows of models that another program estimated.
#include "lab/baselines/recorded.h"

#include <zlib.h>

#include <catch2/catch.hpp>

#include "core/temporary_folder.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/eval/runner.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;

Example FourPoints() {
  Example example;
  example.scene = "s";
  example.id = "s/p1";
  example.problem.task = Task::kLine;
  example.problem.inlier_threshold = 0.1;
  example.problem.points = PointMatrix(4, 2);
  example.problem.points << 0, 1, 1, 1, 2, 1.05, 3, 4;
  return example;
}

RecordedRow Recorded(const TemporaryFolder& folder, const std::string& lines, const std::string& row = "other") {
  WriteFileAtomically(folder.File("r.csv"), lines);
  return RecordedRow({folder.File("r.csv"), row});
}

TEST_CASE("a recorded row has the model of its file, its inliers by the threshold and its milliseconds") {
  const TemporaryFolder folder;
  const auto row = Recorded(folder,
                            "# a comment\nrow,condition,id,seed,ms,model\nother,all,s/p1,1,2.5,0 1 -1\n"
                            "other,\"all, far\",s/p1,2,1.5,\nnobody,all,s/p1,1,9,1 0 0\n");
  const Estimate estimate = row.Of(FourPoints(), "all", 1);
  REQUIRE(estimate.status == Status::kOk);
  CHECK(estimate.model == Eigen::Vector3d(0, 1, -1));
  CHECK(estimate.inliers == std::vector<std::uint8_t>{1, 1, 1, 0});
  CHECK(estimate.stats.ms_total == 2.5);
  const Estimate none = row.Of(FourPoints(), "all, far", 2);
  CHECK(none.status == Status::kNoModel);
  CHECK(none.stats.ms_total == 1.5);
}

TEST_CASE("a recorded row of fewer seeds gives those in turn, and says which problem its file has not") {
  const TemporaryFolder folder;
  const auto row =
      Recorded(folder, "row,condition,id,seed,ms,model\nother,all,s/p1,1,2.5,0 1 -1\nother,all,s/p1,2,1.5,0 1 -1\n");
  CHECK(row.Of(FourPoints(), "all", 3).stats.ms_total == 1.5);
  CHECK(row.Of(FourPoints(), "all", 4).stats.ms_total == 2.5);
  CHECK_THROWS_WITH(row.Of(FourPoints(), "far", 1), Contains("'s/p1'") && Contains("'far'") && Contains("seed 1"));
}

TEST_CASE("a file of recorded models that is none is an error with its line") {
  const TemporaryFolder folder;
  const std::string columns = "row,condition,id,seed,ms,model\n";
  const std::string compressed = folder.File("r.csv.gz");
  const gzFile file = gzopen(compressed.c_str(), "wb");
  gzputs(file, (columns + "other,all,s/p1,1,2.5,1 2 3\n").c_str());
  gzclose(file);
  CHECK_NOTHROW(RecordedRow({compressed, "other"}));
  WriteFileAtomically(compressed, ReadFile(compressed).substr(0, 30));
  CHECK_THROWS_WITH(RecordedRow({compressed, "other"}), Contains("r.csv.gz: is damaged"));
  CHECK_THROWS_WITH(Recorded(folder, "a,b\n"), Contains("r.csv:1") && Contains("row,condition"));
  CHECK_THROWS_WITH(Recorded(folder, columns + "other,all,s/p1\n"), Contains("r.csv:2") && Contains("six"));
  CHECK_THROWS_WITH(Recorded(folder, columns + "other,all,s/p1,x,1,1\n"), Contains("seed 'x'"));
  CHECK_THROWS_WITH(Recorded(folder, columns + "other,all,s/p1,1,1,1 b\n"), Contains("model '1 b'"));
  CHECK_THROWS_WITH(Recorded(folder, columns + "a,all,s/p1,1,1,1\n"), Contains("no row 'other'"));
  CHECK_THROWS_WITH(Recorded(folder, ""), Contains("no row 'other'"));
  CHECK_THROWS_WITH(Recorded(folder, columns + "other,all,s/p1,1,1,1 2\n").Of(FourPoints(), "all", 1),
                    Contains("expected 3 numbers"));
}

TEST_CASE("a table runs a recorded row beside its others, on the same problems") {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& rows) {
    const auto make = [](const Config& row, Task task) { return MakeRow(row, task, {"", "cpu", 1}); };
    const std::string data = "problems: 2\ndata: {type: synthetic_line, split: test, outlier_ratio: 0.5}\n";
    return RunExperiment(ReadExperiment(ConfigFromYaml(data + "methods: {" + rows + "}\n")), {make, {}});
  };
  std::string lines = "row,condition,id,seed,ms,model\n";
  const ExperimentResults before = run("ransac: {type: ransac}");
  for (const ProblemRecord& record : before.cells[0].records) lines += "other,all," + record.id + ",1,1,0 1 0\n";
  WriteFileAtomically(folder.File("r.csv"), lines);
  const ExperimentResults results =
      run("ransac: {type: ransac}, other: {type: recorded, row: other, recording: " + folder.File("r.csv") + "}");
  REQUIRE(results.cells.size() == 2);
  CHECK(results.cells[1].records.size() == 2);
  CHECK(results.cells[1].records[0].stats.ms_total == 1.0);
}

}  // namespace
}  // namespace diffsac
