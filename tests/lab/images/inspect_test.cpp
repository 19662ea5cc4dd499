#include "lab/images/inspect.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/errors.h"
#include "lab/data/two_view_test_util.h"
#include "lab/files/correspondence_files.h"

namespace diffsac {
namespace {

const std::atomic<bool> kNeverStop{false};

}  // namespace

TEST_CASE("inspect finds what is wrong with a scene") {
  TemporaryFolder folder;
  const CorrespondenceSet good = SyntheticSet(3, 30, Rng(4));
  const auto summary_of = [&](auto change) {
    CorrespondenceSet set = good;
    change(set);
    WriteCorrespondences(folder / "scene", set);
    return InspectScene(folder / "scene", 1.0, kNeverStop);
  };
  const auto problems_of = [&](auto change) {
    const SceneSummary summary = summary_of(change);
    std::string text;
    for (const std::string& problem : summary.problems) text += problem + "\n";
    return text;
  };
  const SceneSummary fine = summary_of([](auto&) {});
  CHECK(fine.problems.empty());
  CHECK(fine.labelled_share == Approx(2.0 / 3.0));
  CHECK(fine.mean_share >= 2.0 / 3.0);
  CHECK((fine.matches.min == 30 && fine.matches.max == 30));
  const std::string text = SummaryText({fine}, 1.0);
  CHECK((Has(text, "scene") && Has(text, "66.7") && Has(text, "ok")));

  CHECK(Has(problems_of([](auto& s) { s.pairs[1].problem.points(0, 0) = std::nan(""); }), "not finite"));
  CHECK(Has(problems_of([](auto& s) { s.pairs[1].problem.points(0, 0) = 5000; }), "outside"));
  CHECK(Has(problems_of([](auto& s) { s.pairs[1].problem.snn_ratio[3] = 1.5; }), "ratio"));
  CHECK(Has(problems_of([](auto& s) { s.pairs[1].truth.fundamental->transposeInPlace(); }), "disagree"));
  CHECK(Has(problems_of([](auto& s) { s.pairs[1].truth.essential->transposeInPlace(); }), "disagree"));
  CHECK(Has(problems_of([](auto& s) { s.pairs[1].problem.points.col(1).array() += 60.0; }), "near the truth"));
  CHECK(summary_of([](auto& s) { s.pairs[0].problem.points.row(4) = s.pairs[0].problem.points.row(3); }).repeats == 1);
  CHECK(Has(SummaryText({summary_of([](auto& s) { s.pairs[1].problem.snn_ratio[3] = -1; })}, 1.0), "1 bad"));
}

}  // namespace diffsac
