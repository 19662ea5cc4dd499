#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/report/plot_series.h"

namespace diffsac {

/// A picture of curves. Texts may be anything.
struct LineChart {
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;  ///< Points that a logarithm does not have are left out.
  std::optional<std::pair<double, double>> y_range;  ///< None: that of the points.
  std::vector<Curve> curves;
  int width = 560, height = 380;  ///< Pixels, without the legend beside it.
};

/// A picture of clusters of bars, `rows` the names of a cluster's bars.
struct BarChart {
  std::string title, y_label;
  std::vector<std::string> rows;
  std::vector<BarCluster> clusters;
};

/// SVG to stand in a page of HtmlPage, whose style sheet has its colours, for light and dark pages. The legend stands
/// beside the axes; points and bars tell their values, with intervals, to who points at them. Empty where there is
/// nothing to show.
std::string SvgOf(const LineChart& chart);
std::string SvgOf(const BarChart& chart);

}  // namespace diffsac
