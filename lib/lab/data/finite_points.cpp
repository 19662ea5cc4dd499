#include "lab/data/finite_points.h"

#include <mutex>
#include <set>

#include "diffsac/core/logging.h"
#include "lab/data/pair_filter.h"

namespace diffsac {

std::vector<int> FiniteRows(const PointMatrix& points) {
  std::vector<int> finite;
  for (int i = 0; i < points.rows(); ++i)
    if (points.row(i).allFinite()) finite.push_back(i);
  return finite;
}

Example WithFinitePoints(Example example, const std::string& where) {
  const PointMatrix& points = example.problem.points;
  if (points.allFinite()) return example;
  const std::vector<int> finite = FiniteRows(points);
  const auto bad = static_cast<std::size_t>(points.rows()) - finite.size();
  WarnOnce(where + ": " + std::to_string(bad) + " of " + std::to_string(points.rows()) +
           " points are not finite and are left out");
  return WithRows(example, finite);
}

void WarnOnce(const std::string& line) {
  static std::mutex mutex;
  static std::set<std::string> told;
  const std::lock_guard lock(mutex);
  if (told.insert(line).second) LogWarning(line);
}

}  // namespace diffsac
