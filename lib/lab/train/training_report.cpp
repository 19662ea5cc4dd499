#include "lab/train/training_report.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "lab/eval/format.h"
#include "lab/report/html_page.h"
#include "lab/report/plot_series.h"

namespace diffsac {
namespace {

/// The points of one column, where it has values.
std::vector<CurvePoint> ColumnPoints(const std::vector<std::string>& rows, std::size_t column) {
  std::vector<CurvePoint> points;
  for (const std::string& row : rows) {
    std::istringstream in(row);
    std::string cell;
    std::getline(in, cell, ',');
    const double iteration = std::atof(cell.c_str());
    for (std::size_t i = 0; i <= column; ++i)
      if (!std::getline(in, cell, ',')) cell.clear();
    if (!cell.empty()) points.push_back({iteration, std::strtod(cell.c_str(), nullptr)});
  }
  return points;
}

Table ValuesTable(const std::vector<std::string>& columns, const std::vector<std::string>& rows) {
  Table table{"values", {"column", "first", "smallest", "largest", "last", "at iteration", "values"}, {}};
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::vector<CurvePoint> points = ColumnPoints(rows, c);
    if (points.empty()) continue;
    const auto [low, high] = std::minmax_element(points.begin(), points.end(),
                                                 [](const CurvePoint& a, const CurvePoint& b) { return a.y < b.y; });
    table.rows.push_back({{columns[c], ShortNumber(points.front().y), ShortNumber(low->y), ShortNumber(high->y),
                           ShortNumber(points.back().y), ShortNumber(points.back().x), std::to_string(points.size())},
                          std::vector<bool>(7, false)});
  }
  return table;
}

}  // namespace

std::string TrainingReportHtml(const std::string& title, const std::vector<std::string>& columns,
                               const std::vector<std::string>& rows, const std::string& config,
                               const std::string& curve_png, bool running) {
  constexpr int kReloadSeconds = 10;
  HtmlPage page(title);
  if (running) {
    page.AddReload(kReloadSeconds);
    page.AddSubtitle("The training is running; this page loads itself again every " + std::to_string(kReloadSeconds) +
                     " seconds.");
  }
  if (rows.empty()) {
    page.AddSubtitle("Nothing measured yet.");
  } else {
    page.AddSubtitle("To iteration " + rows.back().substr(0, rows.back().find(',')) + ".");
    if (!curve_png.empty()) {
      page.AddSection("Curves");
      page.AddPicture(
          curve_png,
          "Losses, on the left axis: means over the iterations between two lines of metrics.csv, lower is better. "
          "Validation, on the right: on problems that are not trained on, higher is better.");
    }
    page.AddSection("Values");
    page.AddTable(
        ValuesTable(columns, rows),
        "data_wait_share: the part of the time that the training waited for data. First, smallest, largest and "
        "last value of each column of metrics.csv; at iteration: of the last.");
  }
  page.AddSection("Configuration");
  page.AddMarkup("<pre>" + HtmlText(config) + "</pre>\n");
  return page.Text();
}

}  // namespace diffsac
