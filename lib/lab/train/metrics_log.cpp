#include "lab/train/metrics_log.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "diffsac/core/status.h"
#include "lab/files/files.h"

namespace diffsac {
MetricsLog::MetricsLog(std::string folder, std::vector<std::string> columns, std::int64_t last_iteration)
    : folder_(std::move(folder)), columns_(std::move(columns)) {
  const std::string path = folder_ + "/metrics.csv";
  if (last_iteration <= 0 || !std::filesystem::exists(path)) return;
  std::istringstream old(ReadFile(path));
  std::string line;
  std::getline(old, line);
  if (line != Header())
    throw Error(path + ": its columns are '" + line + "', expected '" + Header() +
                "'; rename it to go on with a new one");
  while (std::getline(old, line))
    if (std::atoll(line.c_str()) <= last_iteration) rows_.push_back(line);
}

std::string MetricsLog::Header() const {
  std::string text = "iteration";
  for (const auto& column : columns_) text += "," + column;
  return text;
}

void MetricsLog::Append(std::int64_t iteration, const std::vector<double>& values) {
  std::string row = std::to_string(iteration);
  for (const double value : values) {
    char text[32] = "";
    if (!std::isnan(value)) std::snprintf(text, sizeof text, "%.6g", value);
    row += std::string(",") + text;
  }
  rows_.push_back(row);
  Write();
}

void MetricsLog::Write() const {
  std::string text = Header();
  for (const auto& row : rows_) text += "\n" + row;
  WriteFileAtomically(folder_ + "/metrics.csv", text + "\n");
}

std::string ValidationMeasure(const std::string& column) {
  for (const char* measure : {"mAA", "recall"})
    if (column.find(measure) != std::string::npos) return measure;
  return "";
}

void MetricsLog::Tell(bool running) {
  if (!running) {
    script_.Start("training_report.py", {folder_});
    script_.Wait();
  } else if (!script_.Runs()) {
    script_.Start("training_report.py", {"--running", folder_});
  }
}

}  // namespace diffsac
