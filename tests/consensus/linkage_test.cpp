#include "diffsac/consensus/structures/linkage.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

// The definition, every pair looked at anew in every round.
std::vector<int> ByDefinition(const PreferenceMatrix& preferences) {
  std::vector<std::vector<int>> clusters;
  std::vector<Eigen::RowVectorXf> own;
  for (int i = 0; i < preferences.rows(); ++i) {
    clusters.push_back({i});
    own.emplace_back(preferences.row(i));
  }
  for (;;) {
    float least = 1.0f;
    std::size_t first = 0, second = 0;
    for (std::size_t a = 0; a < own.size(); ++a)
      for (std::size_t b = a + 1; b < own.size(); ++b) {
        const float common = own[a].dot(own[b]);
        if (common <= 0.0f) continue;
        const float distance = 1.0f - common / (own[a].squaredNorm() + own[b].squaredNorm() - common);
        if (distance < least) least = distance, first = a, second = b;
      }
    if (second == 0) break;
    clusters[first].insert(clusters[first].end(), clusters[second].begin(), clusters[second].end());
    own[first] = own[first].cwiseMin(own[second]).eval();
    clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(second));
    own.erase(own.begin() + static_cast<std::ptrdiff_t>(second));
  }
  std::vector<int> number(static_cast<std::size_t>(preferences.rows()));
  std::sort(clusters.begin(), clusters.end(), [](const auto& a, const auto& b) {
    return *std::min_element(a.begin(), a.end()) < *std::min_element(b.begin(), b.end());
  });
  for (std::size_t c = 0; c < clusters.size(); ++c)
    for (const int i : clusters[c]) number[i] = static_cast<int>(c);
  return number;
}

TEST_CASE("Points with common preferences are one cluster, a point that prefers nothing is alone") {
  PreferenceMatrix preferences(6, 3);
  preferences << 1, 0, 0,  //
      0, 1, 0,             //
      1, 0, 0,             //
      0, 0, 0,             //
      0, 1, 0,             //
      1, 0, 1;
  CHECK(LinkPoints(preferences) == std::vector<int>{0, 1, 0, 2, 1, 0});
  CHECK(LinkPoints(PreferenceMatrix::Zero(0, 3)).empty());
  CHECK(LinkPoints(PreferenceMatrix::Zero(2, 0)) == std::vector<int>{0, 1});
}

TEST_CASE("A bridge between two clusters joins one of them, for they have no hypothesis in common") {
  PreferenceMatrix preferences(5, 2);
  preferences << 1, 0, 1, 0, 1, 1, 0, 1, 0, 1;
  const std::vector<int> clusters = LinkPoints(preferences);
  CHECK(clusters[0] == clusters[1]);
  CHECK(clusters[3] == clusters[4]);
  CHECK(clusters[0] != clusters[3]);
}

TEST_CASE("Clusters are those of the definition, for binary and soft preferences") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Rng rng(seed);
    PreferenceMatrix preferences(14, 9);
    for (Eigen::Index i = 0; i < preferences.size(); ++i) {
      const bool prefers = rng.Uniform() < 0.3;
      preferences.data()[i] = !prefers ? 0.0f : seed % 2 == 0 ? 1.0f : static_cast<float>(rng.Uniform(0.1, 1.0));
    }
    // Ties of binary preferences may be broken otherwise.
    if (seed % 2 == 1) CHECK(LinkPoints(preferences) == ByDefinition(preferences));
    const std::vector<int> clusters = LinkPoints(preferences);
    for (int c = 0; c <= *std::max_element(clusters.begin(), clusters.end()); ++c) {
      Eigen::RowVectorXf common = Eigen::RowVectorXf::Ones(9);
      int size = 0;
      for (int i = 0; i < 14; ++i)
        if (clusters[i] == c) common = common.cwiseMin(preferences.row(i)).eval(), ++size;
      REQUIRE(size > 0);
      CHECK((size == 1 || common.maxCoeff() > 0.0f));
    }
  }
}

}  // namespace
}  // namespace diffsac
