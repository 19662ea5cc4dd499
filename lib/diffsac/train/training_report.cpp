#include "diffsac/train/training_report.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "diffsac/report/html_page.h"
#include "diffsac/report/svg_axes.h"
#include "diffsac/report/svg_chart.h"
#include "diffsac/train/metrics_log.h"

namespace diffsac {
namespace {

constexpr std::size_t kMostPoints = 600;  // Of a curve.

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

/// Averages of neighbours where there are too many to be seen.
std::vector<CurvePoint> Thinned(const std::vector<CurvePoint>& points) {
  const std::size_t together = (points.size() + kMostPoints - 1) / kMostPoints;
  if (together <= 1) return points;
  std::vector<CurvePoint> thinned;
  for (std::size_t i = 0; i < points.size(); i += together) {
    const std::size_t end = std::min(points.size(), i + together);
    CurvePoint mean{points[end - 1].x, 0.0};
    for (std::size_t k = i; k < end; ++k) mean.y += points[k].y / static_cast<double>(end - i);
    thinned.push_back(mean);
  }
  return thinned;
}

bool Has(const std::string& name, const char* part) { return name.find(part) != std::string::npos; }

Table ValuesTable(const std::vector<std::string>& columns, const std::vector<std::string>& rows) {
  Table table{"values", {"column", "first", "smallest", "largest", "last", "at iteration"}, {}};
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::vector<CurvePoint> points = ColumnPoints(rows, c);
    if (points.empty()) continue;
    const auto [low, high] = std::minmax_element(points.begin(), points.end(),
                                                 [](const CurvePoint& a, const CurvePoint& b) { return a.y < b.y; });
    table.rows.push_back({{columns[c], ShortNumber(points.front().y), ShortNumber(low->y), ShortNumber(high->y),
                           ShortNumber(points.back().y), ShortNumber(points.back().x)},
                          std::vector<bool>(6, false)});
  }
  return table;
}

void AddCurves(const std::vector<std::string>& columns, const std::vector<std::string>& rows, HtmlPage* page) {
  LineChart loss, validation, rate;
  loss.title = "Training loss";
  loss.log_y = true;
  validation.title = "Validation";
  validation.y_range = {0.0, 1.0};
  rate.title = "Learning rate";
  loss.y_label = "loss";
  rate.y_label = "learning rate";
  for (std::size_t c = 0; c < columns.size(); ++c) {
    LineChart* chart = Has(columns[c], "loss") ? &loss : !ValidationMeasure(columns[c]).empty() ? &validation : nullptr;
    if (columns[c] == "learning_rate") chart = &rate;
    if (chart == &validation) validation.y_label = ValidationMeasure(columns[c]);
    const std::vector<CurvePoint> points = ColumnPoints(rows, c);
    if (chart == nullptr || points.empty()) continue;
    const CurveKind kind = chart == &validation || points.size() > 200 ? CurveKind::kMethod : CurveKind::kStrong;
    chart->curves.push_back({columns[c], kind, chart->curves.size(), Thinned(points)});
  }
  page->AddSection("Curves");
  for (LineChart* chart : {&loss, &validation, &rate}) {
    chart->x_label = "iteration";
    chart->height = chart == &rate ? 160 : 320;
    const std::string svg = SvgOf(*chart);
    if (!svg.empty())
      page->AddSvg(svg, chart == &loss         ? "Means over the iterations between two lines of metrics.csv."
                        : chart == &validation ? "Higher is better."
                                               : "");
  }
}

}  // namespace

std::string TrainingReportHtml(const std::string& title, const std::vector<std::string>& columns,
                               const std::vector<std::string>& rows, const std::string& config) {
  HtmlPage page(title);
  if (rows.empty()) {
    page.AddSubtitle("Nothing measured yet.");
  } else {
    page.AddSubtitle("To iteration " + rows.back().substr(0, rows.back().find(',')) + ".");
    AddCurves(columns, rows, &page);
    page.AddSection("Values");
    page.AddTable(ValuesTable(columns, rows));
  }
  page.AddSection("Configuration");
  page.AddMarkup("<pre>" + HtmlText(config) + "</pre>\n");
  return page.Text();
}

}  // namespace diffsac
