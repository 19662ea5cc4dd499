#include "lab/train/metrics_log.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/temporary_folder.h"
#include "diffsac/core/files.h"
#include "lab/report/gnuplot.h"

namespace diffsac {
namespace {

using Catch::Contains;
using Columns = std::vector<std::string>;

const Columns kColumns = {"loss", "learning_rate", "mAA@0.5deg"};

struct Curve {
  explicit Curve(const std::vector<std::vector<double>>& rows, const Columns& columns = kColumns) {
    MetricsLog log(folder.path(), columns, 0);
    log.Write();
    for (std::size_t i = 0; i < rows.size(); ++i) log.Append(static_cast<std::int64_t>(i) + 1, rows[i]);
    log.Draw();
  }
  bool has_picture() const { return std::filesystem::exists(folder.File("training_curve.png")); }
  bool has_script() const { return std::filesystem::exists(folder.File("training_curve.gp")); }

  TemporaryFolder folder;
};

}  // namespace

// gnuplot fails where nothing that it is to draw has a value: "gnuplot failed on training_curve.gp".
TEST_CASE("a training that has measured nothing is not given to gnuplot") {
  CHECK_FALSE(Curve({}).has_script());
  CHECK_FALSE(Curve({{kNotMeasured, 0.1, kNotMeasured}}).has_script());
  CHECK_FALSE(Curve({{-1.0, 0.1, kNotMeasured}}).has_script());  // Nothing that a logarithmic axis shows.
}

TEST_CASE("what a training has measured is drawn, losses or validations alone as well") {
  CHECK(Curve({{0.5, 0.1, kNotMeasured}}).has_picture() == HasGnuplot());
  CHECK(Curve({{kNotMeasured, 0.1, 0.3}}).has_picture() == HasGnuplot());
  CHECK(Curve({{0.5, 0.1, kNotMeasured}, {0.4, 0.1, 0.3}}).has_picture() == HasGnuplot());
  CHECK(Curve({{0.5, 0.1, 0.0}, {0.0, 0.1, 0.0}}).has_picture() == HasGnuplot());
  CHECK(Curve({{0.5, kNotMeasured}, {0.4, 0.7}}, {"loss", "recall"}).has_picture() == HasGnuplot());
}

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

TEST_CASE("TensorBoard's file has the rows, and a resumed run goes on in it") {
  const TemporaryFolder folder;
  const std::string path = folder.File(kEventFile);
  {
    MetricsLog log(folder.path(), {"loss", "mAA"}, 0);
    log.Write();
    log.Append(5, {0.5, kNotMeasured});
    log.Append(10, {0.25, 0.75});
  }
  const std::string whole = ReadFile(path);
  CHECK(WholeRecords(whole, 10) == whole.size());
  MetricsLog resumed(folder.path(), {"loss", "mAA"}, 9);
  CHECK(ReadFile(path) == whole);
  resumed.Write();
  CHECK(ReadFile(path) == whole.substr(0, WholeRecords(whole, 5)));
  resumed.Append(10, {0.125, 0.5});
  CHECK(ReadFile(path).size() == whole.size());
}

TEST_CASE("the page of a training that runs loads itself again, until it ends") {
  const TemporaryFolder folder;
  MetricsLog log(folder.path(), kColumns, 0);
  log.Append(5, {0.5, 0.1, 0.3});
  log.WriteReport(true);
  CHECK_THAT(ReadFile(folder.File("report.html")), Contains("http-equiv=\"refresh\"") && Contains("is running"));
  log.WriteReport(false);
  CHECK_THAT(ReadFile(folder.File("report.html")), !Contains("http-equiv=\"refresh\"") && !Contains("is running"));
}

TEST_CASE("rows of other columns are not gone on with") {
  const TemporaryFolder folder;
  MetricsLog(folder.path(), {"loss", "mAA"}, 0).Append(5, {0.5, 0.7});
  CHECK_THROWS_WITH(MetricsLog(folder.path(), {"loss", "recall"}, 5),
                    Contains("metrics.csv: its columns are 'iteration,loss,mAA', expected 'iteration,loss,recall'"));
}

}  // namespace diffsac
