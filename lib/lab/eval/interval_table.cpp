#include "lab/eval/interval_table.h"

#include <cmath>

#include "lab/eval/format.h"

namespace diffsac {
namespace {

/// How one number looks, and those of its interval.
struct Formats {
  const char *value, *end;
};

Formats FormatsOf(IntervalKind kind) {
  switch (kind) {
    case IntervalKind::kDifference:
      return {"%+.3f", "%+.3f"};
    case IntervalKind::kMilliseconds:
      return {"%.3g ms", "%.3g"};
    case IntervalKind::kRatio:
      return {"×%.3g", "%.3g"};
    case IntervalKind::kValue:
      break;
  }
  return {"%.3f", "%.3f"};
}

}  // namespace

std::string IntervalText(const ConfidenceInterval& interval, IntervalKind kind) {
  if (std::isnan(interval.mean)) return kUnknown;
  const Formats formats = FormatsOf(kind);
  const std::string mean = Format(formats.value, interval.mean);
  if (std::isnan(interval.low)) return mean;
  return mean + " [" + Format(formats.end, interval.low) + ", " + Format(formats.end, interval.high) + "]";
}

bool IsCertain(const ConfidenceInterval& interval, IntervalKind kind) {
  if (kind != IntervalKind::kDifference && kind != IntervalKind::kRatio) return false;
  const double none = kind == IntervalKind::kRatio ? 1.0 : 0.0;
  return interval.low > none || interval.high < none;
}

void AddIntervalRow(const std::string& label, const std::vector<std::optional<ConfidenceInterval>>& values,
                    IntervalKind kind, Table* table) {
  Table::Row row{{label}, {false}};
  for (const auto& value : values) {
    row.cells.push_back(value ? IntervalText(*value, kind) : kUnknown);
    row.best.push_back(value && IsCertain(*value, kind));
  }
  table->rows.push_back(std::move(row));
}

}  // namespace diffsac
