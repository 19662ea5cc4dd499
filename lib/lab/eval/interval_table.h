#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lab/eval/report.h"

namespace diffsac {

/// What a number with an interval is: "0.512 [0.450, 0.570]", "+0.208 [+0.154, +0.265]", "2.31 ms [2.1, 2.5]", "×1.32
/// [1.21, 1.45]".
enum class IntervalKind { kValue, kDifference, kMilliseconds, kRatio };

std::string IntervalText(const ConfidenceInterval& interval, IntervalKind kind);

/// Whether a difference or ratio is one beyond chance: its interval leaves 0 or 1 out.
bool IsCertain(const ConfidenceInterval& interval, IntervalKind kind);

/// Adds a row of them, in bold what is certain.
void AddIntervalRow(const std::string& label, const std::vector<std::optional<ConfidenceInterval>>& values,
                    IntervalKind kind, Table* table);

}  // namespace diffsac
