#pragma once

#include <string>
#include <vector>

#include "diffsac/core/enum_names.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// What becomes of points of a file that have a value which is no finite number.
///   kDrop   "drop": they are left out, which one warning says with their number
///   kError  "error": the file is refused
enum class NonFinitePoints { kDrop, kError };
template <>
inline constexpr auto kEnumNames<NonFinitePoints> = NamesOf<NonFinitePoints>({{NonFinitePoints::kDrop, "drop"},
                                                                              {NonFinitePoints::kError, "error"}});

/// The rows without such a value, ascending.
std::vector<int> FiniteRows(const PointMatrix& points);

/// The example without such points. where: the file and key, for the warning and the Error.
Example WithFinitePoints(Example example, NonFinitePoints non_finite, const std::string& where);

/// LogWarning, once in a process for the same line: data sets are read again for pictures and labels. Thread-safe.
void WarnOnce(const std::string& line);

}  // namespace diffsac
