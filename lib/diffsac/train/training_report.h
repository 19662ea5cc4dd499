#pragma once

#include <string>
#include <vector>

namespace diffsac {

/// report.html of a training run: the curves of metrics.csv (losses, validation, learning rate), first, best and last
/// values, and `config`, the run's configuration. `rows` are lines of that file: the iteration, then a value for each
/// column, empty where there is none.
std::string TrainingReportHtml(const std::string& title, const std::vector<std::string>& columns,
                               const std::vector<std::string>& rows, const std::string& config);

}  // namespace diffsac
