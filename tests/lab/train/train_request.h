#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "lab/config/yaml.h"
#include "lab/options/options.h"
#include "lab/train/trainer.h"

namespace diffsac {

/// For trainings that nothing interrupts.
inline const std::atomic<bool> kNever{false};

/// A training on one thread of the CPU; `changes` as `--set` takes them.
inline TrainRequest OneThread(Config config, const std::string& output, const std::vector<std::string>& changes = {}) {
  for (const auto& change : changes) SetYaml(&config, change);
  TrainRequest request(config);
  request.output = output;
  request.device = "cpu";
  request.threads = 1;
  return request;
}

/// A line's cells for each line of a run's metrics.csv, the columns' names first, without the measured data_wait_share.
/// None where there is no such file yet; a line that is being written counts as far as it is.
inline std::vector<std::vector<std::string>> Metrics(const std::string& run) {
  std::ifstream file(run + "/metrics.csv");
  std::vector<std::vector<std::string>> rows;
  std::ptrdiff_t measured = 0;
  for (std::string line, cell; std::getline(file, line);) {
    auto& row = rows.emplace_back();
    std::istringstream cells(line + ",");
    while (std::getline(cells, cell, ',')) row.push_back(cell);
    if (rows.size() == 1) measured = std::find(row.begin(), row.end(), "data_wait_share") - row.begin();
    if (measured < static_cast<std::ptrdiff_t>(row.size())) row.erase(row.begin() + measured);
  }
  return rows;
}

/// The values of a column, NaN where a cell is empty.
inline std::vector<double> Column(const std::vector<std::vector<std::string>>& metrics, const std::string& name) {
  const auto at = static_cast<std::size_t>(std::find(metrics[0].begin(), metrics[0].end(), name) - metrics[0].begin());
  std::vector<double> values;
  for (std::size_t i = 1; i < metrics.size(); ++i)
    values.push_back(metrics[i].at(at).empty() ? std::nan("") : std::stod(metrics[i][at]));
  return values;
}

/// A training that is stopped once `reached`, in whichever step it then is.
inline TrainOutcome TrainUntil(const TrainRequest& request, const std::function<bool()>& reached) {
  std::atomic<bool> stop{false};
  std::thread watcher([&] {
    while (!reached()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    stop = true;
  });
  const TrainOutcome outcome = Train(request, stop);
  watcher.join();
  return outcome;
}

/// Goes on with what was stopped.
inline TrainOutcome Resume(TrainRequest request) {
  request.resume = true;
  return Train(request, kNever);
}

}  // namespace diffsac
