#include "lab/report/page_checks.h"

#include <catch2/catch.hpp>

#include "core/temporary_folder.h"
#include "diffsac/core/files.h"

namespace diffsac {
namespace {

using Catch::Contains;

std::string Page(const std::string& row, const std::string& revision) {
  const std::string text = "# t\n\n## mAA\n\n| method | x |\n|---|---:|\n| " + row +
                           " | 0.5 |\n| Published (paper, other data) | 0.4 |\n\n- git revision: " + revision + "\n";
  return text + PageDigestLine(text);
}

struct Fixture {
  TemporaryFolder folder;
  Fixture() {
    WriteFileAtomically(folder.File("t.yaml"),
                        "name: t\ndata: {type: synthetic_line}\nmethods: {ransac: {type: ransac, label: RANSAC 20}}\n"
                        "paper: {Published: {all: {mAA: 0.4}}}\n");
  }
  std::vector<std::string> Faults(const std::string& page) const {
    WriteFileAtomically(folder.File("t.md"), page);
    return PageFaults(folder.File("t.md"), folder.File("t.yaml"));
  }
};

TEST_CASE("a page as it was written has no faults") { CHECK(Fixture().Faults(Page("RANSAC 20", "abc1")).empty()); }

TEST_CASE("a number that was changed by hand, a dirty tree and a row that no configuration has are faults") {
  const Fixture fixture;
  std::string changed = Page("RANSAC 20", "abc1");
  changed.replace(changed.find("0.5"), 3, "0.6");
  REQUIRE(fixture.Faults(changed).size() == 1);
  CHECK_THAT(fixture.Faults(changed)[0], Contains("t.md: was changed after it was written"));
  CHECK_THAT(fixture.Faults(Page("RANSAC 20", "abc1-dirty")).at(0), Contains("tree with changes"));
  CHECK_THAT(fixture.Faults(Page("RANSAC 30", "abc1")).at(0), Contains("has no row 'RANSAC 30'"));
  CHECK_THAT(fixture.Faults("# t\n").at(0), Contains("no digest"));
}

}  // namespace
}  // namespace diffsac
