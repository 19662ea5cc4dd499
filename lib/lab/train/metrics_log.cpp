#include "lab/train/metrics_log.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/report/colours.h"
#include "lab/report/gnuplot.h"
#include "lab/train/training_report.h"

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
    : folder_(std::move(folder)),
      columns_(std::move(columns)),
      events_((std::filesystem::path(folder_) / kEventFile).string(), last_iteration) {
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
  WriteTable();
  Scalars scalars;
  for (std::size_t i = 0; i < columns_.size(); ++i) scalars.emplace_back(columns_[i], values[i]);
  events_.Add(iteration, scalars);
}

void MetricsLog::Write() {
  WriteTable();
  events_.Begin();
}

void MetricsLog::WriteTable() const {
  std::string text = Header();
  for (const auto& row : rows_) text += "\n" + row;
  WriteFileAtomically(folder_ + "/metrics.csv", text + "\n");
}

std::string ValidationMeasure(const std::string& column) {
  for (const char* measure : {"mAA", "recall"})
    if (column.find(measure) != std::string::npos) return measure;
  return "";
}

void MetricsLog::WriteReport(bool running) const {
  const std::filesystem::path folder(folder_), config = folder / "config.yaml", curve = folder / "training_curve.png";
  std::string page;
  try {
    const std::string text = std::filesystem::exists(config) ? ReadFile(config.string()) : "";
    const std::string name = std::filesystem::weakly_canonical(folder).filename().string();
    page = TrainingReportHtml("Training of " + name, columns_, rows_, text,
                              std::filesystem::exists(curve) ? ReadFile(curve.string()) : "", running);
  } catch (const std::exception& error) {
    return LogWarning(folder_ + ": no report.html: " + error.what());
  }
  WriteFileAtomically((folder / "report.html").string(), page);
}

namespace {

/// Losses are lines of different dashes, validations points of different marks, so that nobody needs their colours.
std::string CurveStyle(std::size_t index, bool loss, bool one_row) {
  static constexpr int kMarks[] = {7, 5, 9, 11, 13, 6, 4, 8};
  const std::string colour = " lc rgb '" + std::string(SeriesColour(index)) + "'";
  const std::string mark = " pt " + std::to_string(kMarks[index % std::size(kMarks)]) + " ps 1.2";
  if (!loss) return " axes x1y2 with linespoints lw 1 dt 3" + mark + colour;
  if (one_row) return " with points" + mark + colour;  // One point is no line.
  return " with lines lw 2 dt " + std::to_string(1 + index % 4) + colour;
}

}  // namespace

// gnuplot fails where all that it is to draw has no value.
void MetricsLog::Draw() const {
  std::string measure, curves;
  bool losses = false;
  std::size_t shown = 0;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const bool loss = columns_[i].find("loss") != std::string::npos;
    const std::string validation = ValidationMeasure(columns_[i]);
    if ((!loss && validation.empty()) || !HasValue(i, loss)) continue;
    losses = losses || loss;
    if (measure.empty()) measure = validation;
    const std::string title = loss ? columns_[i] + " (left)" : columns_[i] + " (right)";
    curves += (curves.empty() ? "" : ", ") + ("'metrics.csv' every ::1 using 1:" + std::to_string(i + 2)) +
              CurveStyle(shown++, loss, rows_.size() == 1) + " title " + GnuplotText(title);
  }
  if (curves.empty()) return;
  const std::string loss_axis = losses ? "set ylabel 'loss'\nset logscale y\nset ytics nomirror\n" : "unset ytics\n";
  const std::string validation_axis =
      measure.empty() ? ""
                      : "set y2label " + GnuplotText("validation " + measure) + "\nset y2tics\nset y2range [0:1]\n";
  DrawPicture(folder_, "training_curve",
              "set datafile separator ','\nset key outside below center horizontal maxcols 2 samplen 5\n"
              "set grid ls 100\nset title 'Training curve'\nset xlabel 'iteration'\nset format x '%.1s%c'\n" +
                  loss_axis + validation_axis + "plot " + curves,
              1100, 640);
}

}  // namespace diffsac
