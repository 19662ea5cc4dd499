#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "lab/config/report_script.h"

namespace diffsac {

/// Leaves a cell of metrics.csv empty.
inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// What a column of validation measures, "mAA" or, of several structures, "recall"; empty for other columns.
std::string ValidationMeasure(const std::string& column);

/// metrics.csv of a training run, a picture of it (training_curve.png) and a page (report.html), both by
/// scripts/report.
class MetricsLog {
 public:
  /// Keeps rows up to `last_iteration` of an earlier, interrupted run in the same folder, of which nothing is written
  /// yet. Throws Error where that one's columns are others.
  MetricsLog(std::string folder, std::vector<std::string> columns, std::int64_t last_iteration);
  /// values: one for each column, `kNotMeasured` where there is none.
  void Append(std::int64_t iteration, const std::vector<double>& values);
  /// Writes metrics.csv with the rows so far.
  void Write() const;
  /// Draws the curves and writes the page. `running`: a browser is to load it again and again; it is made beside the
  /// training, and not at all while one is being made. That it cannot be made is a warning in the log.
  void Tell(bool running);

 private:
  std::string Header() const;

  std::string folder_;
  std::vector<std::string> columns_;
  std::vector<std::string> rows_;
  ReportScript script_;
};

}  // namespace diffsac
