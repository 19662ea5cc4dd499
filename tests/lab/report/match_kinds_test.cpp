#include "lab/report/match_kinds.h"

#include <catch2/catch.hpp>

namespace diffsac {

TEST_CASE("matches are right, wrong and missed, each counted once") {
  const std::vector<std::uint8_t> found = {1, 1, 0, 0, 1, 0}, truth = {1, 0, 1, 0, 1, 0};
  const MatchKind kinds[] = {MatchKind::kRight, MatchKind::kWrong, MatchKind::kMissed,
                             MatchKind::kOther, MatchKind::kRight, MatchKind::kOther};
  for (std::size_t i = 0; i < 6; ++i) CHECK(KindOfMatch(found, truth, i) == kinds[i]);
  const MatchCounts counts = CountMatches(found, truth, 6);
  CHECK(counts.right == 2);
  CHECK(counts.wrong == 1);
  CHECK(counts.missed == 1);
}

TEST_CASE("without a truth what is found is right; a failed estimate misses all that is true") {
  const std::vector<std::uint8_t> some = {1, 0, 1};
  const MatchCounts untold = CountMatches(some, {}, 3), failed = CountMatches({}, some, 3);
  CHECK(untold.right == 2);
  CHECK((untold.wrong == 0 && untold.missed == 0));
  CHECK(failed.missed == 2);
  CHECK((failed.right == 0 && failed.wrong == 0));
}

}  // namespace diffsac
