#include "lab/report/html_report.h"
#include "lab/config/yaml.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "diffsac/core/files.h"
#include "lab/config/dataset_factory.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/files/thumbnails.h"
#include "lab/report/pair_images.h"
#include "lab/report/pair_pictures.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;
using Json = nlohmann::json;

/// What stands in the page's data of this id; empty where there is none.
std::string DataOf(const std::string& html, const std::string& id) {
  const std::size_t at = html.find("id=\"" + id + "\">");
  if (at == std::string::npos) return "";
  const std::size_t begin = html.find('>', at) + 1;
  return html.substr(begin, html.find("</script>", begin) - begin);
}

std::string FromBase64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = (bits << 6) | static_cast<unsigned>(digits.find(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>((bits >> count) & 255);
  }
  return bytes;
}

bool HasBit(const std::string& mask, std::size_t i) { return (static_cast<unsigned char>(mask[i / 8]) >> (i % 8)) & 1; }

/// Calls every third match of two views an inlier, with a matrix that is no good.
struct EveryThird : RobustEstimator {
  diffsac::Estimate DoRun(const Problem& problem, std::uint64_t) const override {
    diffsac::Estimate estimate;
    estimate.status = Status::kOk;
    estimate.model = Eigen::VectorXd::LinSpaced(9, 1.0, 2.0);
    for (Eigen::Index i = 0; i < problem.points.rows(); ++i) estimate.inliers.push_back(i % 3 == 0);
    return estimate;
  }
};

ExperimentResults TwoViewResults(const std::string& more = "") {
  const ExperimentOptions experiment = ReadExperiment(ConfigFromYaml(R"(
name: views
task: fundamental
problems: 7
data: {type: synthetic_two_view, task: fundamental, num_points: 30}
methods:
  - {name: a, type: third, label: "</script><script>alert(1)</script>"}
  - {name: b, type: third}
)" + more));
  return RunExperiment(experiment, {[](const Config&, Task) { return std::make_unique<EveryThird>(); }, {}, nullptr});
}

TEST_CASE("a report has the tables with intervals, the pictures and every problem, and needs nothing beside it") {
  ExperimentResults results = MadeUpResults();
  results.experiment.figures.bars = {"first", "second"};
  const Report report = MakeReport(results);
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("bars.png"), "png");
  const std::string html = ReportHtml(report, folder.path());
  for (const Table& table : report.tables) CHECK_THAT(html, Contains("<caption>" + table.heading));
  CHECK_THAT(html, Contains("data-value=\"0.85\">0.850 <small>[0.750, 0.950]") &&
                       Contains("src=\"data:image/png;base64,cG5n\"") &&
                       Contains("higher is better, with 95 % intervals"));
  CHECK_THAT(html, !Contains("http:") && !Contains("https:") && !Contains("url("));
  results.partial = true;
  CHECK_THAT(ReportHtml(MakeReport(results), folder.path()), !Contains("data:image/png"));
  const Json list = Json::parse(DataOf(html, "problems"));
  CHECK(list["problems"].size() == 8);
  CHECK(list["lines"].size() == 24);
  CHECK(list["methods"] == Json({"First", "Second", "Oracle"}));
  CHECK(list["lines"][0][3] == Approx(0.045));
}

TEST_CASE("of several structures the report lists misclassification and recall") {
  const ExperimentResults results = MadeUpStructures(), one = MadeUpResults();
  const std::string html = ReportHtml(MakeReport(results));
  const Json list = Json::parse(DataOf(html, "problems"));
  CHECK(list["unit"] == "%");
  CHECK(list["structures"] == true);
  // Second on condition 0.5: problem, method, status, error, recall, structures, inliers, hypotheses, ms.
  CHECK(list["lines"][17] == Json({5, 1, 0, 75.0, 0.25, 3, 20, 20, 0.5}));
  CHECK_THAT(html, !Contains("mAA@"));
  const Json plain = Json::parse(DataOf(ReportHtml(MakeReport(one)), "problems"));
  CHECK(plain["structures"] == false);
  CHECK(plain["lines"][0].size() == 7);
}

TEST_CASE("the fits of several structures are named with their errors") {
  ExperimentResults results = MadeUpStructures();
  const Example example = LinesCross();
  results.fits = {{0, example, LinesFound(example), 0}};
  CHECK_THAT(ReportHtml(MakeReport(results)), Contains("Fits</h2>") && Contains("error 0 %"));
}

TEST_CASE("names of users stay texts, failures are listed as the worst") {
  ExperimentResults results = MadeUpResults();
  results.experiment.title = results.experiment.methods[0].label = "</script><script>alert(1)</script>";
  ProblemRecord& failed = results.cells[0].records[2];
  failed.id = "</script><script>alert(2)</script>\xff";
  failed.status = Status::kDegenerate;
  failed.error = {INFINITY, INFINITY, true};
  const std::string html = ReportHtml(MakeReport(results));
  CHECK_THAT(html, !Contains("<script>alert"));
  const Json list = Json::parse(DataOf(html, "problems"));
  CHECK(list["problems"][2][0].get<std::string>().starts_with("</script><script>alert(2)"));
  CHECK(list["lines"][2][3] == "inf");
  CHECK(list["statuses"][list["lines"][2][2].get<int>()] == "degenerate");
}

TEST_CASE("matches of two views are there to a quarter pixel, with the inliers of each method and of the truth") {
  const ExperimentResults results = TwoViewResults();
  const std::string html = ReportHtml(MakeReport(results));
  CHECK_THAT(html, !Contains("<script>alert"));
  const Json pictures = Json::parse(DataOf(html, "pictures"));
  REQUIRE(pictures.size() == 7);
  const auto dataset = MakeDataset(results.experiment.conditions[0].data, results.experiment.seed);
  const Example example = dataset->Get(4);
  const std::string bytes = FromBase64(DataOf(html, "points-" + std::to_string(pictures[4][0].get<int>())));
  REQUIRE(bytes.size() == 4 + 8 * 30);
  float step = 0.0F;
  std::memcpy(&step, bytes.data(), 4);
  CHECK(step == 0.25F);
  for (int i = 0; i < 120; ++i) {
    std::int16_t value = 0;
    std::memcpy(&value, bytes.data() + 4 + 2 * i, 2);
    CHECK(step * value == Approx(example.problem.points(i / 4, i % 4)).margin(0.126));
  }
  CHECK(pictures[4][7] == 1);             // The truth is known,
  CHECK(pictures[4][8] == Json({0, 1}));  // and both methods' inliers.
  const std::string masks = FromBase64(DataOf(html, "masks-4"));
  REQUIRE(masks.size() == 3 * 4);
  for (std::size_t i = 0; i < 30; ++i) {
    CHECK(HasBit(masks, i) == (example.truth.inliers[i] != 0));
    CHECK(HasBit(masks.substr(8), i) == (i % 3 == 0));
  }
}

TEST_CASE("without estimates the kept fits have their inliers, and others are not drawn") {
  ExperimentResults results = TwoViewResults("estimates: false\nfigures: {qualitative: 2}\n");
  const std::string html = ReportHtml(MakeReport(results));
  const Json pictures = Json::parse(DataOf(html, "pictures"));
  REQUIRE(pictures.size() == 2);
  CHECK(pictures[0][8] == Json({0, 1}));
  CHECK_THAT(html, Contains("only 2 of 7 pairs have a picture"));
  results.fits.clear();
  CHECK(DataOf(ReportHtml(MakeReport(results)), "pictures").empty());
}

TEST_CASE("of too many problems the worst, the best and some between are shown, and the page says so") {
  std::vector<double> errors;
  for (int i = 0; i < 100; ++i) errors.push_back((i * 37) % 100);
  errors[5] = std::nan("");
  const auto chosen = LargestSmallestAndSpread(errors, 12);
  CHECK(chosen.size() == 12);
  CHECK(std::is_sorted(chosen.begin(), chosen.end()));
  std::vector<double> shown;
  for (const std::size_t i : chosen) shown.push_back(errors[i]);
  CHECK(std::count_if(shown.begin(), shown.end(), [](double e) { return e >= 94; }) >= 6);
  CHECK(std::count_if(shown.begin(), shown.end(), [](double e) { return std::isnan(e) || e <= 2; }) == 3);
  CHECK(std::count_if(shown.begin(), shown.end(), [](double e) { return e > 2 && e < 94; }) >= 2);
  CHECK(LargestSmallestAndSpread(errors, 100).size() == 100);

  const ExperimentResults results = TwoViewResults();
  HtmlPage page("t");
  std::vector<std::string> notes;
  const PictureNumbers numbers = AddPairPictures(results, ListProblems(results), {3, 1'000'000, 0}, &page, &notes);
  CHECK(std::count(numbers.begin(), numbers.end(), -1) == 4);
  REQUIRE(notes.size() == 1);
  CHECK_THAT(notes[0], Contains("3 of 7 pairs have a picture"));
  std::size_t left_out = 0;
  const ProblemList list = ListProblems(MadeUpResults());
  CHECK(Json::parse(ProblemListJson(MadeUpResults(), list, {}, 1, &left_out))["lines"].size() == 24);
  CHECK(left_out == 0);  // Never fewer than a few of each method.
  ExperimentResults one = MadeUpResults();
  one.cells.resize(1);
  for (int i = 4; i < 40; ++i) {
    one.cells[0].records.push_back(one.cells[0].records[0]);
    one.cells[0].records.back().index = i;
  }
  CHECK(Json::parse(ProblemListJson(one, ListProblems(one), {}, 20, &left_out))["lines"].size() == 20);
  CHECK(left_out == 20);
}

TEST_CASE(
    "photographs stand below the matches, from files or from the scene's small copies, as small as they must be") {
  const TemporaryFolder folder;
  WriteThumbnails(folder.path(), {"left"}, [](std::size_t) {
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", cv::Mat(480, 640, CV_8UC3, cv::Scalar(0, 0, 200)), bytes);
    return std::string(bytes.begin(), bytes.end());
  });
  CHECK(LoadImageOf({}, "scene", folder.path(), "left", {}, 640).size() == cv::Size(640, 480));
  CHECK(LoadImageOf({}, "scene", folder.path(), "right", {}, 640).empty());
  cv::imwrite(folder.File("left.png"), cv::Mat(60, 80, CV_8UC3, cv::Scalar(0, 0, 0)));
  CHECK(LoadImageOf({{"sc*", folder.path()}}, "scene", "", "left", {}, 640).size() == cv::Size(80, 60));
}

TEST_CASE("lines and planes have their fits") {
  for (const char* type : {"synthetic_line", "synthetic_plane"}) {
    const bool line = std::string(type) == "synthetic_line";
    const ExperimentOptions experiment = ReadExperiment(ConfigFromYaml(
        std::string("name: x\ntask: ") + (line ? "line" : "plane") + "\nproblems: 3\ndata: {type: " + type +
        "}\nmethods: {oracle: {type: oracle}, a: {type: none}}\n"));
    struct Failing : RobustEstimator {
      diffsac::Estimate DoRun(const Problem&, std::uint64_t) const override { return {}; }
    };
    const ExperimentResults results =
        RunExperiment(experiment, {[](const Config&, Task) { return std::make_unique<Failing>(); }, {}, nullptr});
    CHECK_THAT(ReportHtml(MakeReport(results)), Contains("Fits</h2>") && Contains("no model (no_model)"));
  }
}

TEST_CASE("a report that is not wanted is removed, one that cannot be written is an error") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpResults();
  WriteReport(MakeReport(results), folder.path());
  CHECK(std::filesystem::exists(folder.File(kReportFile)));
  CHECK_THROWS_WITH(WriteReport(MakeReport(results), folder.File("nowhere/at/all")),
                    Contains("nowhere/at/all/report.html"));
  results.experiment.report = false;
  WriteReport(MakeReport(results), folder.path());
  CHECK_FALSE(std::filesystem::exists(folder.File(kReportFile)));
}

}  // namespace
}  // namespace diffsac
