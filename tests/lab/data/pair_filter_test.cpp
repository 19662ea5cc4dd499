#include "lab/data/pair_filter.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "lab/data/two_view_test_util.h"

namespace diffsac {
namespace {

Example OnePair() {
  Example pair = SyntheticSet(1, 60, Rng(3)).pairs.front();
  pair.id = "scene/" + pair.id;
  return pair;
}

PairFilter Capped(PointCap cap) {
  PairFilter filter;
  filter.max_points = 10;
  filter.cap = cap;
  return filter;
}

}  // namespace

TEST_CASE("without a filter a pair stays what it is") {
  const Example pair = OnePair(), same = Filtered(pair, {});
  CHECK(same.id == pair.id);
  CHECK(same.image2 == pair.image2);
  CHECK(same.problem.points == pair.problem.points);
  CHECK(same.problem.match_ratio == pair.problem.match_ratio);
  CHECK(same.problem.similarities == pair.problem.similarities);
  CHECK(same.problem.descriptors == pair.problem.descriptors);
  CHECK(same.truth.assignment == pair.truth.assignment);
}

TEST_CASE("matches are filtered by ratio and number, in their order") {
  const Example pair = OnePair();
  PairFilter filter;
  filter.max_ratio = 0.8;
  const Example filtered = Filtered(pair, filter);
  CHECK(filtered.problem.points.rows() == (pair.problem.match_ratio.array() <= 0.8).count());
  CHECK((filtered.problem.match_ratio.array() <= 0.8).all());
  const Example best = Filtered(pair, Capped(PointCap::kBest));
  REQUIRE(best.problem.points.rows() == 10);
  Eigen::VectorXd sorted = pair.problem.match_ratio;
  std::sort(sorted.begin(), sorted.end());
  CHECK(best.problem.match_ratio.maxCoeff() <= sorted[9]);
}

TEST_CASE("ratios that are not to be known neither filter nor order, and are gone") {
  const Example pair = OnePair();
  PairFilter filter;
  filter.ratios = false;
  filter.max_ratio = 0.8;
  const Example unrated = Filtered(pair, filter);
  CHECK(unrated.problem.match_ratio.size() == 0);
  CHECK(unrated.problem.points == pair.problem.points);
  CHECK(unrated.problem.descriptors == pair.problem.descriptors);
  CHECK(unrated.truth.assignment == pair.truth.assignment);
  PairFilter capped = Capped(PointCap::kBest);
  CHECK(KeptRows(pair, capped) != std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  capped.ratios = false;
  CHECK(KeptRows(pair, capped) == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
}

TEST_CASE("similarities that are not to be known are gone") {
  Example pair = OnePair();
  pair.problem.similarities = PointMatrix::Random(pair.problem.points.rows(), 2);
  PairFilter filter;
  CHECK(Filtered(pair, filter).problem.similarities == pair.problem.similarities);
  filter.similarities = false;
  CHECK(Filtered(pair, filter).problem.similarities.size() == 0);
  CHECK(Filtered(pair, filter).problem.match_ratio == pair.problem.match_ratio);
}

TEST_CASE("what belongs to a match goes with it") {
  const Example pair = OnePair();
  PairFilter filter = Capped(PointCap::kRandom);
  filter.shuffle_points = true;
  const std::vector<int> rows = KeptRows(pair, filter);
  const Example filtered = Filtered(pair, filter);
  REQUIRE(rows.size() == 10);
  CHECK(!std::is_sorted(rows.begin(), rows.end()));
  for (int i = 0; i < 10; ++i) {
    CHECK(filtered.problem.points.row(i) == pair.problem.points.row(rows[i]));
    CHECK(filtered.problem.match_ratio[i] == pair.problem.match_ratio[rows[i]]);
    CHECK(filtered.problem.similarities.row(i) == pair.problem.similarities.row(rows[i]));
    CHECK(filtered.problem.descriptors.row(i) == pair.problem.descriptors.row(rows[i]));
    CHECK(filtered.truth.assignment[i] == pair.truth.assignment[rows[i]]);
  }
  CHECK(KeptRows(pair, filter) == rows);
}

TEST_CASE("what is not known of the matches stays empty") {
  Example pair = OnePair();
  pair.problem.match_ratio.resize(0);
  pair.problem.similarities.resize(0, 0);
  pair.problem.descriptors.resize(0, 0);
  pair.truth.assignment.clear();
  const Example first = Filtered(pair, Capped(PointCap::kBest));
  CHECK(first.problem.points == pair.problem.points.topRows(10));
  CHECK(first.problem.match_ratio.size() == 0);
  CHECK(first.problem.similarities.size() == 0);
  CHECK(first.problem.descriptors.size() == 0);
  CHECK(first.truth.assignment.empty());
}

TEST_CASE("noise of descriptors is as strong as asked for, for each image, and the same whenever a pair is read") {
  Example pair = OnePair();
  pair.problem.descriptors.resize(pair.problem.points.rows(), 256);
  pair.problem.descriptors.leftCols(128).setConstant(2.0f);
  pair.problem.descriptors.rightCols(128).setConstant(10.0f);
  PairFilter filter;
  filter.descriptor_noise = 0.5;
  const DescriptorMatrix noisy = Filtered(pair, filter).problem.descriptors;
  const DescriptorMatrix noise = noisy - pair.problem.descriptors;
  const double values = static_cast<double>(noise.size()) / 2.0;
  CHECK(noise.leftCols(128).norm() / std::sqrt(values) == Approx(1.0).epsilon(0.05));
  CHECK(noise.rightCols(128).norm() / std::sqrt(values) == Approx(5.0).epsilon(0.05));
  CHECK(Filtered(pair, filter).problem.descriptors == noisy);
}

}  // namespace diffsac
