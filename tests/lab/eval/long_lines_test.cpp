#include "lab/eval/run_files.h"

#include <catch2/catch.hpp>

#include "lab/eval/factor_fixtures.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

/// `good` rows are right everywhere, `plain` ones where at least half of the points are inliers.
ExperimentResults HardAndEasy() {
  return MadeUpFactors([](std::size_t, std::size_t m, int i) { return m >= 3 || i >= 6 ? 0.0 : 90.0; });
}

TEST_CASE("results.csv has effects and strata, each by its name") {
  const ExperimentResults results = HardAndEasy();
  const std::string csv = CsvOf(results);
  CHECK_THAT(csv, Contains("factors,synthetic_two_view,mean,all,score=good,mAA@10deg,0.625\n") &&
                      Contains(",mean,all,score=good,mAA@10deg_low,0.") && Contains(",mean,ratio,score=good,ms,10\n") &&
                      Contains(",mean,all,draws=some,combinations,2\n"));
  CHECK_THAT(csv, Contains(",inlier_share below 0.2,all,plain_few,mAA@10deg,0\n") &&
                      Contains(",inlier_share 0.2-0.5,ratio,good_many,problems,3\n") &&
                      Contains(",inlier_share from 0.5,all,good_many - plain_few,mAA@10deg_high,0\n") &&
                      Contains(",inlier_share below 0.2,all,score=good,mAA@10deg,1\n") &&
                      !Contains("below 0.2,all,score=good,mAA@10deg_low"));
}

TEST_CASE("in a bin every problem weighs the same, and few problems tell no interval") {
  // Of the bin from .2 to .5 problem 3 is of scene a, problems 4 and 5 of scene b.
  const ExperimentResults results = MadeUpFactors([](std::size_t, std::size_t, int i) { return i == 3 ? 0.0 : 90.0; });
  CHECK_THAT(CsvOf(results), Contains(",inlier_share 0.2-0.5,all,plain_few,mAA@10deg,0.333333333\n") &&
                                 !Contains("0.2-0.5,all,plain_few,mAA@10deg_low") &&
                                 Contains("from 0.5,all,plain_few,mAA@10deg_low,0\n"));
}

}  // namespace
}  // namespace diffsac
