#include "lab/ground_truth/instances_error.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

// The largest sum over all ways to give the rows of the shorter side a place of the longer one.
double BruteForce(const Eigen::MatrixXd& gains) {
  const Eigen::MatrixXd wide = gains.rows() <= gains.cols() ? gains : Eigen::MatrixXd(gains.transpose());
  std::vector<int> order(static_cast<std::size_t>(wide.cols()));
  std::iota(order.begin(), order.end(), 0);
  double best = -1e300;
  do {
    double sum = 0.0;
    for (Eigen::Index r = 0; r < wide.rows(); ++r) sum += wide(r, order[static_cast<std::size_t>(r)]);
    best = std::max(best, sum);
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

double SumOf(const Eigen::MatrixXd& gains, const std::vector<int>& columns) {
  double sum = 0.0;
  for (std::size_t r = 0; r < columns.size(); ++r)
    if (columns[r] >= 0) sum += gains(static_cast<Eigen::Index>(r), columns[r]);
  return sum;
}

TEST_CASE("the best assignment is that of brute force, whatever the shape") {
  Rng rng(11);
  for (int rows = 1; rows <= 6; ++rows)
    for (int columns = 1; columns <= 6; ++columns)
      for (int round = 0; round < 20; ++round) {
        Eigen::MatrixXd gains(rows, columns);
        // Half of them with many ties, as counts and zeros and ones have.
        for (double& gain : gains.reshaped())
          gain = round % 2 == 0 ? rng.Uniform(-5.0, 5.0) : static_cast<double>(rng.Below(3));
        const std::vector<int> matched = BestAssignment(gains);
        REQUIRE(matched.size() == static_cast<std::size_t>(rows));
        CHECK(SumOf(gains, matched) == Approx(BruteForce(gains)).margin(1e-12));
        std::vector<int> used;
        for (const int column : matched)
          if (column >= 0) used.push_back(column);
        CHECK(used.size() == static_cast<std::size_t>(std::min(rows, columns)));
        std::sort(used.begin(), used.end());
        CHECK(std::adjacent_find(used.begin(), used.end()) == used.end());
      }
}

TEST_CASE("nothing to assign") {
  CHECK(BestAssignment(Eigen::MatrixXd(0, 3)).empty());
  CHECK(BestAssignment(Eigen::MatrixXd(2, 0)) == std::vector<int>{-1, -1});
}

}  // namespace
}  // namespace diffsac
