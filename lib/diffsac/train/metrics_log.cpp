#include "diffsac/train/metrics_log.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/report/gnuplot.h"
#include "diffsac/train/training_report.h"

namespace diffsac {
namespace {

std::string Cell(const std::string& row, std::size_t index) {
  std::istringstream cells(row);
  std::string cell;
  for (std::size_t i = 0; i <= index; ++i)
    if (!std::getline(cells, cell, ',')) return "";
  return cell;
}

}  // namespace

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

bool MetricsLog::HasValue(std::size_t column, bool positive) const {
  return std::any_of(rows_.begin(), rows_.end(), [&](const std::string& row) {
    const std::string cell = Cell(row, column + 1);
    return !cell.empty() && (!positive || std::strtod(cell.c_str(), nullptr) > 0.0);
  });
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

void MetricsLog::WriteReport() const {
  const std::filesystem::path folder(folder_), config = folder / "config.yaml", curve = folder / "training_curve.png";
  std::string page;
  try {
    const std::string text = std::filesystem::exists(config) ? ReadFile(config.string()) : "";
    const std::string name = std::filesystem::weakly_canonical(folder).filename().string();
    page = TrainingReportHtml("Training of " + name, columns_, rows_, text,
                              std::filesystem::exists(curve) ? ReadFile(curve.string()) : "");
  } catch (const std::exception& error) {
    return LogWarning(folder_ + ": no report.html: " + error.what());
  }
  WriteFileAtomically((folder / "report.html").string(), page);
}

// gnuplot fails where all that it is to draw has no value.
void MetricsLog::Draw() const {
  std::string measure, curves;
  bool losses = false;
  const std::string line = rows_.size() > 1 ? " with lines lw 2" : " with points pt 5 ps 1";  // One point is no line.
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const bool loss = columns_[i].find("loss") != std::string::npos;
    const std::string validation = ValidationMeasure(columns_[i]);
    if ((!loss && validation.empty()) || !HasValue(i, loss)) continue;
    losses = losses || loss;
    if (measure.empty()) measure = validation;
    curves += (curves.empty() ? "" : ", ") + ("'metrics.csv' every ::1 using 1:" + std::to_string(i + 2)) +
              (loss ? line : " axes x1y2 with points pt 7 ps 1") + " lc rgb '" + SeriesColour(i) + "' title " +
              GnuplotText(columns_[i]);
  }
  if (curves.empty()) return;
  const std::string loss_axis = losses ? "set ylabel 'loss'\nset logscale y\nset ytics nomirror\n" : "unset ytics\n";
  const std::string validation_axis =
      measure.empty() ? ""
                      : "set y2label " + GnuplotText("validation " + measure) + "\nset y2tics\nset y2range [0:1]\n";
  DrawPicture(folder_, "training_curve",
              "set datafile separator ','\nset key outside right top\nset grid ls 100\nset title 'Training curve'\n"
              "set xlabel 'iteration'\nset format x '%.1s%c'\n" +
                  loss_axis + validation_axis + "plot " + curves,
              1100, 640);
}

}  // namespace diffsac
