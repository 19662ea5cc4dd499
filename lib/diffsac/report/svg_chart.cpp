#include "diffsac/report/svg_chart.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "diffsac/report/gnuplot.h"
#include "diffsac/report/html_page.h"
#include "diffsac/report/svg_axes.h"

namespace diffsac {
namespace {

constexpr double kLeft = 74, kTop = 30, kBelow = 46, kLegendGap = 18, kLegendLine = 19, kMostLegend = 330;

std::string Colour(std::size_t index) { return "var(--s" + std::to_string(index % kSeriesColours) + ")"; }

std::string ColourOf(const Curve& curve) {
  if (curve.kind == CurveKind::kCeiling) return "var(--ink)";
  return curve.kind == CurveKind::kReference ? "var(--soft)" : Colour(curve.colour);
}

bool IsLineAlone(const Curve& curve) {
  return curve.kind == CurveKind::kCeiling || curve.kind == CurveKind::kReference || curve.points.size() > 200;
}

// Colours repeat after seven curves, which are dashed then.
std::string Stroke(const Curve& curve) {
  std::string style = "stroke:" + ColourOf(curve) + ";stroke-width:" + (curve.kind == CurveKind::kStrong ? "3" : "1.8");
  if (curve.kind == CurveKind::kCeiling) style += ";stroke-dasharray:7 4";
  else if (curve.kind == CurveKind::kReference) style += ";stroke-dasharray:2 3";
  else if (curve.colour >= kSeriesColours) style += ";stroke-dasharray:9 3 2 3";
  return "style=\"fill:none;" + style + "\"";
}

std::string IntervalText(double value, double low, double high) {
  std::string text = ShortNumber(value);
  if (std::isfinite(low) && std::isfinite(high)) text += " [" + ShortNumber(low) + ", " + ShortNumber(high) + "]";
  return text;
}

/// Another shape for every seven curves.
std::string Mark(const Curve& curve, double x, double y, const std::string& tip) {
  const std::string fill = " style=\"fill:" + ColourOf(curve) + "\">";
  const std::string title = tip.empty() ? "" : "<title>" + HtmlText(tip) + "</title>";
  if (curve.colour < kSeriesColours)
    return "<circle cx=\"" + SvgNumber(x) + "\" cy=\"" + SvgNumber(y) + "\" r=\"3.6\"" + fill + title + "</circle>";
  return "<rect x=\"" + SvgNumber(x - 3.4) + "\" y=\"" + SvgNumber(y - 3.4) + "\" width=\"6.8\" height=\"6.8\"" + fill +
         title + "</rect>";
}

std::string Whisker(double x, double low, double high, const std::string& colour) {
  const std::string at = SvgNumber(x), left = SvgNumber(x - 3), right = SvgNumber(x + 3);
  const std::string l = SvgNumber(low), h = SvgNumber(high);
  return "<path d=\"M" + at + " " + l + "V" + h + "M" + left + " " + l + "H" + right + "M" + left + " " + h + "H" + right +
         "\" style=\"fill:none;stroke-width:1;opacity:.6;stroke:" + colour + "\"/>";
}

bool IsShown(const CurvePoint& point, const LineChart& chart) {
  return std::isfinite(point.x) && std::isfinite(point.y) && (!chart.log_x || point.x > 0.0) &&
         (!chart.log_y || point.y > 0.0);
}

std::string CurveMarkup(const Curve& curve, const LineChart& chart, const SvgAxis& x, const SvgAxis& y) {
  std::string path, marks;
  for (const CurvePoint& point : curve.points) {
    if (!IsShown(point, chart)) continue;
    const double at_x = x.At(point.x), at_y = y.At(point.y);
    path += (path.empty() ? "M" : "L") + SvgNumber(at_x) + " " + SvgNumber(at_y);
    if (IsLineAlone(curve)) continue;
    if (std::isfinite(point.low) && std::isfinite(point.high))
      marks += Whisker(at_x, y.At(point.low), y.At(point.high), ColourOf(curve));
    marks += Mark(curve, at_x, at_y,
                  curve.label + ": " + IntervalText(point.y, point.low, point.high) + " at " + ShortNumber(point.x));
  }
  if (path.empty()) return "";
  const bool line = curve.kind != CurveKind::kPoints;
  return (line ? "<path d=\"" + path + "\" " + Stroke(curve) + "/>" : "") + marks + "\n";
}

double LegendWidth(const std::vector<std::string>& labels) {
  double width = 0.0;
  for (const std::string& label : labels) width = std::max(width, TextWidth(label));
  return std::min(kMostLegend, width + 44);
}

std::string LegendOf(const std::vector<Curve>& curves, double x) {
  std::string svg;
  double y = kTop + 6;
  for (const Curve& curve : curves) {
    if (curve.kind != CurveKind::kPoints)
      svg += "<path d=\"M" + SvgNumber(x) + " " + SvgNumber(y) + "h26\" " + Stroke(curve) + "/>";
    if (!IsLineAlone(curve)) svg += Mark(curve, x + 13, y, "");
    svg += SvgText(x + 34, y + 4, curve.label);
    y += kLegendLine;
  }
  return svg + "\n";
}

SvgAxis AxisOf(const LineChart& chart, bool of_y) {
  std::vector<double> values;
  for (const Curve& curve : chart.curves)
    for (const CurvePoint& point : curve.points)
      if (IsShown(point, chart)) values.push_back(of_y ? point.y : point.x);
  return FitAxis(values, of_y ? chart.log_y : chart.log_x);
}

}  // namespace

std::string SvgOf(const LineChart& chart) {
  std::vector<std::string> labels;
  for (const Curve& curve : chart.curves) labels.push_back(curve.label);
  if (labels.empty()) return "";
  SvgAxis x = AxisOf(chart, false), y = AxisOf(chart, true);
  if (chart.y_range) std::tie(y.low, y.high) = *chart.y_range;
  x.first = kLeft;
  x.last = kLeft + chart.width;
  y.first = kTop + chart.height;
  y.last = kTop;
  const double legend = x.last + kLegendGap;
  const double legend_end = kTop + kLegendLine * static_cast<double>(labels.size());
  std::string svg = SvgText(kLeft, 16, chart.title, "class=\"title\"") + SvgFrame(x, y, chart.x_label, chart.y_label);
  // What the reader should see first is drawn last.
  for (const bool strong : {false, true})
    for (const Curve& curve : chart.curves)
      if ((curve.kind == CurveKind::kStrong) == strong) svg += CurveMarkup(curve, chart, x, y);
  svg += LegendOf(chart.curves, legend);
  return SvgPicture(legend + LegendWidth(labels), std::max(y.first + kBelow, legend_end), chart.title, svg);
}

namespace {

/// Where the bars of a chart stand.
struct BarPlaces {
  explicit BarPlaces(const BarChart& chart) {
    const auto rows = static_cast<double>(chart.rows.size()), clusters = static_cast<double>(chart.clusters.size());
    bar = std::clamp(640.0 / (rows * clusters), 8.0, 26.0);
    cluster = bar * (rows + 1.2);
    for (const BarCluster& one : chart.clusters) cluster = std::max(cluster, TextWidth(one.label) + 14);
    first = (cluster - bar * rows) / 2;
    end = kLeft + cluster * clusters;
  }
  double Left(std::size_t c, std::size_t r) const {
    return kLeft + cluster * static_cast<double>(c) + first + bar * static_cast<double>(r);
  }
  double Middle(std::size_t c) const { return kLeft + cluster * (static_cast<double>(c) + 0.5); }
  double bar = 0.0, cluster = 0.0, first = 0.0, end = 0.0;
};

/// Paler from the eighth row on.
std::string BarStyle(std::size_t row) {
  return " style=\"fill:" + Colour(row) + (row < kSeriesColours ? "\"" : ";opacity:.55\"");
}

std::string BarMarkup(const BarChart& chart, const BarPlaces& places, const SvgAxis& y, std::size_t c, std::size_t r) {
  const ConfidenceInterval& value = chart.clusters[c].bars[r];
  if (std::isnan(value.mean)) return "";
  const double left = places.Left(c, r), top = y.At(value.mean);
  const std::string tip =
      chart.rows[r] + ", " + chart.clusters[c].label + ": " + IntervalText(value.mean, value.low, value.high);
  return "<rect x=\"" + SvgNumber(left) + "\" y=\"" + SvgNumber(top) + "\" width=\"" + SvgNumber(places.bar - 2) +
         "\" height=\"" + SvgNumber(y.first - top) + "\"" + BarStyle(r) + "><title>" + HtmlText(tip) +
         "</title></rect>" + Whisker(left + places.bar / 2 - 1, y.At(value.low), y.At(value.high), "var(--ink)") + "\n";
}

}  // namespace

std::string SvgOf(const BarChart& chart) {
  if (chart.rows.empty() || chart.clusters.empty()) return "";
  const BarPlaces places(chart);
  SvgAxis x, y;
  x.first = kLeft;
  x.last = places.end;
  y.first = kTop + 340;
  y.last = kTop;
  std::string svg = SvgText(kLeft, 16, chart.title, "class=\"title\"") + SvgFrame(x, y, "", chart.y_label, false);
  for (std::size_t c = 0; c < chart.clusters.size(); ++c) {
    for (std::size_t r = 0; r < chart.rows.size(); ++r) svg += BarMarkup(chart, places, y, c, r);
    svg += SvgText(places.Middle(c), y.first + 17, chart.clusters[c].label, "text-anchor=\"middle\"");
  }
  const double legend = x.last + kLegendGap;
  for (std::size_t r = 0; r < chart.rows.size(); ++r) {
    const double at = kTop + kLegendLine * static_cast<double>(r);
    svg += "<rect x=\"" + SvgNumber(legend) + "\" y=\"" + SvgNumber(at) + "\" width=\"14\" height=\"12\"" +
           BarStyle(r) + "/>" + SvgText(legend + 22, at + 10, chart.rows[r]);
  }
  const double legend_end = kTop + kLegendLine * static_cast<double>(chart.rows.size());
  return SvgPicture(legend + LegendWidth(chart.rows), std::max(y.first + 34, legend_end), chart.title, svg + "\n");
}

}  // namespace diffsac
