#include "diffsac/train/metrics_log.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/eval/gnuplot.h"
#include "diffsac/train/training_report.h"

namespace diffsac {

MetricsLog::MetricsLog(std::string folder, std::vector<std::string> columns, std::int64_t last_iteration)
    : folder_(std::move(folder)), columns_(std::move(columns)) {
  const std::string path = folder_ + "/metrics.csv";
  if (last_iteration > 0 && std::filesystem::exists(path)) {
    std::istringstream old(ReadFile(path));
    std::string line;
    std::getline(old, line);
    while (std::getline(old, line))
      if (std::atoll(line.c_str()) <= last_iteration) rows_.push_back(line);
  }
  Write();
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
  std::string text = "iteration";
  for (const auto& column : columns_) text += "," + column;
  for (const auto& row : rows_) text += "\n" + row;
  WriteFileAtomically(folder_ + "/metrics.csv", text + "\n");
}

std::string ValidationMeasure(const std::string& column) {
  for (const char* measure : {"mAA", "recall"})
    if (column.find(measure) != std::string::npos) return measure;
  return "";
}

void MetricsLog::WriteReport() const {
  const std::filesystem::path folder(folder_), config = folder / "config.yaml";
  std::string page;
  try {
    const std::string text = std::filesystem::exists(config) ? ReadFile(config.string()) : "";
    const std::string name = std::filesystem::weakly_canonical(folder).filename().string();
    page = TrainingReportHtml("Training of " + name, columns_, rows_, text);
  } catch (const std::exception& error) {
    return LogWarning(folder_ + ": no report.html: " + error.what());
  }
  WriteFileAtomically((folder / "report.html").string(), page);
}

void MetricsLog::Draw() const {
  std::string measure;
  for (const std::string& column : columns_) measure = measure.empty() ? ValidationMeasure(column) : measure;
  std::string script =
      "set datafile separator ','\nset key outside right top\nset grid ls 100\nset title 'Training curve'\n"
      "set xlabel 'iteration'\nset ylabel 'loss'\nset logscale y\nset format x '%.1s%c'\nset y2label " +
      GnuplotText("validation " + measure) +
      "\nset y2tics\nset ytics nomirror\n"
      "set y2range [0:1]\nplot ";
  std::string separator;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const bool loss = columns_[i].find("loss") != std::string::npos;
    const bool accuracy = !ValidationMeasure(columns_[i]).empty();
    if (!loss && !accuracy) continue;
    script += separator + "'metrics.csv' every ::1 using 1:" + std::to_string(i + 2) +
              (accuracy ? " axes x1y2 with points pt 7 ps 1" : " with lines lw 2") + " lc rgb '" + SeriesColour(i) +
              "' title " + GnuplotText(columns_[i]);
    separator = ", ";
  }
  DrawPicture(folder_, "training_curve", script, 1100, 640);
}

}  // namespace diffsac
