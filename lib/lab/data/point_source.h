#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace diffsac {

/// Where the points of a problem come from.
struct PointSource {
  std::string path;  ///< The file.
  std::string name;  ///< Of the set in it (PointSet::name).
  /// Which of the file's points the problem has, ascending; empty: all of them.
  std::vector<std::int32_t> rows;
  std::int64_t total = 0;  ///< Points in the file.
};

/// What data of files has beside Dataset: it can say where a problem's points come from.
class HasPointSources {
 public:
  virtual ~HasPointSources() = default;
  /// Of the example at a place, from 0.
  virtual const PointSource& SourceOf(std::uint64_t index) const = 0;
};

}  // namespace diffsac
