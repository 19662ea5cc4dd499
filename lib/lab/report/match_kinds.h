#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace diffsac {

/// What an estimate makes of a point, and whether that is so; without a truth every inlier is right.
enum class MatchKind { kOther, kMissed, kRight, kWrong };

inline MatchKind KindOfMatch(const std::vector<std::uint8_t>& found, const std::vector<std::uint8_t>& truth,
                             std::size_t i) {
  const bool is_found = i < found.size() && found[i] != 0;
  if (i >= truth.size()) return is_found ? MatchKind::kRight : MatchKind::kOther;
  if (is_found) return truth[i] != 0 ? MatchKind::kRight : MatchKind::kWrong;
  return truth[i] != 0 ? MatchKind::kMissed : MatchKind::kOther;
}

/// How many of each.
struct MatchCounts {
  int right = 0, wrong = 0, missed = 0;
};

inline MatchCounts CountMatches(const std::vector<std::uint8_t>& found, const std::vector<std::uint8_t>& truth,
                                std::size_t points) {
  MatchCounts counts;
  for (std::size_t i = 0; i < points; ++i) {
    const MatchKind kind = KindOfMatch(found, truth, i);
    counts.right += kind == MatchKind::kRight;
    counts.wrong += kind == MatchKind::kWrong;
    counts.missed += kind == MatchKind::kMissed;
  }
  return counts;
}

}  // namespace diffsac
