#include "diffsac/estimate/score_check.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace diffsac {
namespace {

constexpr double kLikely = 1.64, kSure = 3.0;  // Of RankTest::z.

/// Whether inliers are better scored than the others, by the rank test of Mann and Whitney.
struct RankTest {
  double z = 0.0;      ///< By how many standard deviations they are; 0 where the scores are all alike.
  double sigma = 1.0;  ///< Of the share of pairs, one inlier and one other, of which the inlier is the better scored.
  double share = 0.0;  ///< Of inliers.
  bool IsReversed() const { return z < -kSure; }
  /// Scores that are worth something would show it: of two matches the right one is the better scored in .65 of cases.
  bool IsMeaningless() const { return z < kLikely && 4.0 * sigma < 0.15; }
  /// Where most matches are inliers, little depends on scores, and few others say little of them.
  bool IsDoubtful() const { return z < (share < 0.5 ? kSure : -kLikely) || IsMeaningless(); }
  bool IsWorthless() const { return IsReversed() || IsMeaningless(); }
};

struct Ranked {
  double ratio;
  bool inlier;
};

/// Of up to kMost of the matches. Those that are not finite are left out, with ratios that may be anything.
std::vector<Ranked> RankedMatches(const Problem& problem, const std::vector<std::uint8_t>& inliers) {
  constexpr Eigen::Index kMost = 10000;
  std::vector<Ranked> ranked;
  const Eigen::Index count = problem.points.rows(), step = (count + kMost - 1) / kMost;
  for (Eigen::Index i = 0; i < count; i += step)
    if (std::isfinite(problem.snn_ratio[i]) && problem.points.row(i).allFinite())
      ranked.push_back({problem.snn_ratio[i], inliers[static_cast<std::size_t>(i)] != 0});
  std::sort(ranked.begin(), ranked.end(), [](const Ranked& a, const Ranked& b) { return a.ratio < b.ratio; });
  return ranked;
}

RankTest TestRanks(const Problem& problem, const Estimate& estimate) {
  const std::vector<Ranked> ranked = RankedMatches(problem, estimate.inliers);
  const auto n = static_cast<double>(ranked.size());
  // Of pairs of an inlier and another match: those whose inlier is the better scored, less those whose other one is.
  double inliers = 0.0, others = 0.0, surplus = 0.0, ties = 0.0;
  for (auto first = ranked.begin(); first != ranked.end();) {
    const auto last =
        std::find_if(first, ranked.end(), [&](const Ranked& match) { return match.ratio > first->ratio; });
    const auto equal = static_cast<double>(last - first);
    const auto in = static_cast<double>(std::count_if(first, last, [](const Ranked& match) { return match.inlier; }));
    surplus += inliers * (equal - in) - others * in;
    inliers += in;
    others += equal - in;
    ties += equal * (equal * equal - 1.0);
    first = last;
  }
  const double alike = n > 1.0 ? ties / (n * (n * n - 1.0)) : 1.0;
  if (!(inliers * others > 0.0 && alike < 1.0)) return {};
  const double sigma = std::sqrt((n + 1.0) * (1.0 - alike) / (12.0 * inliers * others));
  return {0.5 * surplus / (inliers * others) / sigma, sigma, inliers / n};
}

/// The greatest log10_nfa of an estimate without scores that is taken in the place of this one.
double NeededSupport(const RankTest& test, const Estimate& with) {
  constexpr double kMuch = 1.2, kAsMuch = 0.75;
  constexpr double kClear = -20.0;  // Of wrong models of a scene that repeats itself few have more support.
  if (!with.IsSure()) return test.IsReversed() ? 0.0 : kClear;
  if (test.IsWorthless()) return kAsMuch * with.log10_nfa;
  return std::min(kMuch * with.log10_nfa, kClear);
}

bool Says(const Problem& problem) {
  const Eigen::VectorXd& ratios = problem.snn_ratio;
  return ratios.size() == problem.points.rows() &&
         std::any_of(ratios.begin(), ratios.end(), [&](double ratio) { return ratio != ratios[0]; });
}

}  // namespace

bool DoubtsScores(const Problem& problem, const Estimate& estimate) {
  if (estimate.status != Status::kOk && estimate.status != Status::kNoModel) return false;
  if (!Says(problem)) return false;
  if (!estimate.IsSure()) return true;
  return TestRanks(problem, estimate).IsDoubtful();
}

bool IsBetterWithoutScores(const Problem& problem, const Estimate& without, const Estimate& with) {
  return without.IsSure() && !(without.log10_nfa > NeededSupport(TestRanks(problem, without), with));
}

}  // namespace diffsac
