#pragma once

#include <string>
#include <vector>

#include "lab/ground_truth/example.h"

namespace diffsac {

/// The rows without a value that is no finite number, ascending.
std::vector<int> FiniteRows(const PointMatrix& points);

/// The example without points that have such a value, of whose number a warning tells. where: the file and key.
Example WithFinitePoints(Example example, const std::string& where);

/// LogWarning, once in a process for the same line: data sets are read again for pictures and labels. Thread-safe.
void WarnOnce(const std::string& line);

}  // namespace diffsac
