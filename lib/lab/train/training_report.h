#pragma once

#include <string>
#include <vector>

namespace diffsac {

/// report.html of a training run: the picture of its curves (the bytes of a PNG file; empty: none), first, best and
/// last values of metrics.csv, and `config`, the run's configuration. `rows` are lines of that file: the iteration,
/// then a value for each column, empty where there is none. `running`: the page asks the browser to load it again every
/// few seconds.
std::string TrainingReportHtml(const std::string& title, const std::vector<std::string>& columns,
                               const std::vector<std::string>& rows, const std::string& config,
                               const std::string& curve_png, bool running);

}  // namespace diffsac
