#include "lab/report/results_page.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/report/command_line.h"
#include "lab/report/page_checks.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

EvalRequest PageRequest(const TemporaryFolder& folder) {
  WriteFileAtomically(folder.File("x.yaml"),
                      "name: x\nproblems: 8\ndata: {type: synthetic_line, split: test}\n"
                      "methods: {ransac: {type: ransac, max_iterations: 20}}\n");
  EvalRequest request;
  request.config_path = folder.File("x.yaml");
  request.output = folder.File("run");
  request.page = folder.File("docs/x.md");
  request.page_command = "make x";
  request.update = true;
  return request;
}

std::string Run(const EvalRequest& request) {
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  CHECK(Evaluate(request, {}, stop, out) == kExitOk);
  return out.str();
}

TEST_CASE("a page has the tables, the pictures and what made it; a run that is there is not made again") {
  const TemporaryFolder folder;
  EvalRequest request = PageRequest(folder);
  CHECK_THAT(Run(request), Contains("mAA@0.5deg"));
  const std::string page = ReadFile(request.page);
  CHECK_THAT(page, Contains("mAA@0.5deg") && Contains("Written by `make x`") && Contains("- date: ") &&
                       Contains("- git revision: ") && Contains("- libraries: LibTorch ") && !Contains("program"));
  const std::string resolved = ReadFile(folder.File("docs/resolved/x.yaml"));
  CHECK(resolved.starts_with("name: "));
  CHECK_THAT(resolved, Contains("threshold_deg: 0.5") && !Contains("# date"));
  CHECK_THAT(Run(request), Contains("made already"));
  request.limit = 5;  // Another experiment.
  CHECK_THAT(Run(request), Contains("mAA@0.5deg"));
  CHECK_THAT(Run(request), Contains("made already"));
  WriteFileAtomically(request.page, "of another run");
  CHECK_THAT(Run(request), Contains("mAA@0.5deg"));
  std::filesystem::remove(folder.File("run/table.md"));
  CHECK_THAT(Run(request), Contains("mAA@0.5deg"));
}

TEST_CASE("a run that broke off does not pass for the one whose results were there before") {
  const TemporaryFolder folder;
  EvalRequest request = PageRequest(folder);
  Run(request);
  WriteFileAtomically(folder.File("points.csv"), "1,2\nno numbers\n");
  WriteFileAtomically(folder.File("broken.yaml"),
                      "name: x\ntask: line\ndata: {type: point_sets, task: line, paths: [" + folder.File("points.csv") +
                          "], inlier_threshold: 0.1}\nmethods: {ransac: {type: ransac, max_iterations: 20}}\n");
  EvalRequest broken = request;
  broken.config_path = folder.File("broken.yaml");
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  CHECK_THROWS_AS(Evaluate(broken, {}, stop, out), Error);
  CHECK_FALSE(std::filesystem::exists(folder.File("run/results.json")));
  CHECK_THAT(ReadFile(folder.File("run/config.yaml")), Contains("points.csv"));
  CHECK_THAT(Run(request), Contains("mAA@0.5deg"));
  // Killed after the tables, before pictures and report.
  std::filesystem::remove(folder.File("run/results.json"));
  std::filesystem::remove(folder.File("run/report.html"));
  CHECK_THAT(Run(request), Contains("mAA@0.5deg"));
  CHECK(std::filesystem::exists(folder.File("run/report.html")));
}

TEST_CASE("two pictures of matches are on a page, from first to last, and all others") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.File("run"));
  WriteFileAtomically(folder.File("run/config.yaml"), "# program: p\n# seed: 3\n\nname: x\n");
  WriteFileAtomically(folder.File("run/table.md"), "# X\n");
  WriteFileAtomically(
      folder.File("run/results.json"),
      "{\"facts\": {\"seconds\": 61.4, \"peak_memory_mib\": 99.6, \"data_sha256\": \"0123456789abcdef\", "
      "\"networks_sha256\": {\"models/x/y.safetensors\": \"fedcba9876543210\"}}}");
  for (const char* name : {"matches_a", "matches_b", "matches_c", "matches_d", "bars", "curve"})
    WriteFileAtomically(folder.File(std::string("run/") + name + ".png"), name);
  WritePage(folder.File("run"), folder.File("page.md"), "c");
  const std::string text =
      "# X\n\n![page: bars](page_bars.png)\n\n![page: curve](page_curve.png)\n\n![page: "
      "matches_a](page_matches_a.png)\n\n"
      "![page: matches_c](page_matches_c.png)\n\nWritten by `c`.\n\n- seed: 3\n"
      "- time: 61 s\n- peak memory: 100 MiB\n- data: sha256 0123456789ab\n"
      "- network: models/x/y.safetensors, sha256 fedcba987654\n"
      "- configuration, with every key: [page.yaml](resolved/page.yaml)\n";
  CHECK(ReadFile(folder.File("page.md")) == text + PageDigestLine(text));
  CHECK(ReadFile(folder.File("resolved/page.yaml")) == "name: x\n");
  CHECK(ReadFile(folder.File("page_matches_c.png")) == "matches_c");
  CHECK_FALSE(std::filesystem::exists(folder.File("page_matches_b.png")));
}

}  // namespace
}  // namespace diffsac
