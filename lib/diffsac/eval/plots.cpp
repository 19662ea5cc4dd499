#include "diffsac/eval/plots.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "diffsac/eval/gnuplot.h"
#include "diffsac/eval/plot_texts.h"

namespace diffsac {
namespace {

double CellAccuracy(const Report& report, std::size_t condition, std::size_t method) {
  return report.Metric(condition, method, "mean", MetricName("mAA", report.results.experiment.tolerance()));
}

struct Point {
  double x = 0.0;
  double y = 0.0;
};

// One curve: its data block and how it is drawn.
struct Curve {
  std::string label;
  std::string style;
  std::vector<Point> points;
};

std::string Block(const std::string& name, const std::vector<Point>& points) {
  std::string text = "$" + name + " << EOD\n";
  for (const Point& point : points) text += GnuplotNumber(point.x) + " " + GnuplotNumber(point.y) + "\n";
  return text + "EOD\n";
}

std::string PlotCommand(const std::string& prefix, const std::vector<Curve>& curves) {
  std::string blocks, command = "plot ";
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const std::string name = prefix + std::to_string(i);
    blocks += Block(name, curves[i].points);
    command += (i == 0 ? "" : ", \\\n  ") + ("$" + name) + " using 1:2 " + curves[i].style + " title " +
               GnuplotText(curves[i].label);
  }
  return blocks + command + "\n";
}

// Colours repeat after seven series; the marks do not before fourteen.
std::string SeriesStyle(std::size_t index, bool strong) {
  static constexpr int kMarks[] = {7, 5, 9, 11, 13, 15, 3, 4, 6, 12, 8, 10, 14, 2};
  return "with linespoints lc rgb \"" + std::string(SeriesColour(index)) + "\" lw " + (strong ? "3" : "2") + " pt " +
         std::to_string(kMarks[index % std::size(kMarks)]) + " ps 1.2";
}

constexpr int kKeyWidth = 260;  // In pixels.
constexpr const char* kCeilingStyle = "with lines dt 2 lw 2 lc rgb \"#000000\"";
constexpr const char* kReferenceStyle = "with lines dt 3 lw 2 lc rgb \"#666666\"";

std::string RowStyle(const MethodRow& row, std::size_t index) {
  if (row.type == "oracle") return kCeilingStyle;
  return row.Competes() ? SeriesStyle(index, row.type == "diffsac") : kReferenceStyle;
}

// The lines of one condition's panel against a cost; the ceiling spans the whole axis.
std::vector<Curve> CostCurves(const Report& report, std::size_t condition, const std::string& cost) {
  std::vector<Curve> curves;
  const ExperimentOptions& experiment = report.results.experiment;
  const auto& methods = experiment.methods;
  double low = 1e300, high = 0.0;
  for (const BudgetSeries& series : experiment.figures.budget) {
    Curve curve{series.label, SeriesStyle(curves.size(), curves.empty()), {}};
    for (const std::string& name : series.methods) {
      for (std::size_t m = 0; m < methods.size(); ++m) {
        if (methods[m].name != name) continue;
        const Point point{report.Metric(condition, m, "mean", cost), CellAccuracy(report, condition, m)};
        // The axis is logarithmic: what cost nothing has no place on it.
        if (!(point.x > 0.0) || std::isnan(point.y)) continue;
        curve.points.push_back(point);
        low = std::min(low, point.x);
        high = std::max(high, point.x);
      }
    }
    std::sort(curve.points.begin(), curve.points.end(), [](Point a, Point b) { return a.x < b.x; });
    if (!curve.points.empty()) curves.push_back(std::move(curve));
  }
  for (std::size_t m = 0; m < methods.size() && !curves.empty(); ++m) {
    const double ceiling = CellAccuracy(report, condition, m);
    if (methods[m].type == "oracle" && !std::isnan(ceiling))
      curves.push_back({methods[m].label, kCeilingStyle, {{low, ceiling}, {high, ceiling}}});
  }
  return curves;
}

std::vector<Curve> ConditionCurves(const Report& report) {
  std::vector<Curve> curves;
  const ExperimentOptions& experiment = report.results.experiment;
  for (std::size_t m = 0; m < experiment.methods.size(); ++m) {
    const MethodRow& row = experiment.methods[m];
    Curve curve{row.label, RowStyle(row, curves.size()), {}};
    for (std::size_t c = 0; c < experiment.conditions.size(); ++c) {
      const Point point{experiment.conditions[c].value.value_or(std::nan("")), CellAccuracy(report, c, m)};
      if (!std::isnan(point.x) && !std::isnan(point.y)) curve.points.push_back(point);
    }
    if (curve.points.size() >= 2) curves.push_back(std::move(curve));
  }
  return curves;
}

// `cost`: the metric on the x axis. The panels share one key, beside them so that it hides no curve.
bool PlotCost(const Report& report, const std::string& folder, const std::string& cost, const std::string& x_label,
              const std::string& name) {
  const ExperimentResults& results = report.results;
  struct Panel {
    std::size_t condition = 0;
    std::vector<Curve> curves;
  };
  std::vector<Panel> panels;
  std::size_t richest = 0;
  for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c) {
    Panel panel{c, CostCurves(report, c, cost)};
    if (panel.curves.empty()) continue;
    panels.push_back(std::move(panel));
    if (panels.back().curves.size() > panels[richest].curves.size()) richest = panels.size() - 1;
  }
  if (panels.empty()) return false;
  const int count = static_cast<int>(panels.size()), width = 80 + 380 * count + kKeyWidth;
  const double right = 1.0 - static_cast<double>(kKeyWidth) / width, left = 70.0 / width;
  std::string script = "set multiplot layout 1," + std::to_string(count) + " title " + GnuplotText(PlotTitle(results)) +
                       " font \",13\" margins " + GnuplotNumber(left) + "," + GnuplotNumber(right) +
                       ",0.13,0.85 spacing " + GnuplotNumber(left) + "\n" + AccuracyAxes(results, x_label) +
                       "set logscale x\nset yrange [0:1]\n";
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const Condition& condition = results.experiment.conditions[panels[i].condition];
    script += (i == richest ? "set key at screen 0.995, screen 0.85 right top samplen 2\n" : "unset key\n") +
              ("set title " + GnuplotText(results.experiment.condition_label + ": " + condition.label)) + "\n" +
              PlotCommand(name + std::to_string(panels[i].condition) + "_", panels[i].curves);
  }
  return DrawPicture(folder, name, script + "unset multiplot\n", width, 480);
}

}  // namespace

bool PlotCurve(const Report& report, const std::string& folder) {
  const ExperimentResults& results = report.results;
  const std::vector<Curve> curves = ConditionCurves(report);
  if (curves.empty()) return false;
  const std::string script = "set title " + GnuplotText(PlotTitle(results)) + " font \",13\"\n" +
                             AccuracyAxes(results, results.experiment.condition_label) +
                             "set key outside right center samplen 2 spacing 1.2\nset yrange [0:1]\n" +
                             "set offsets graph 0.02, graph 0.02, 0, 0\n" + PlotCommand("curve", curves);
  return DrawPicture(folder, "curve", script, 960, 560);
}

bool PlotBudget(const Report& report, const std::string& folder) {
  return PlotCost(report, folder, "hypotheses", "hypotheses (models solved or scored)", "budget");
}

bool PlotTime(const Report& report, const std::string& folder) {
  return PlotCost(report, folder, "ms_total", "milliseconds (median)", "time");
}

void DrawExamples(const ExperimentResults& results, const std::string& folder) {
  PlotFits(results, folder);
  PlotMatches(results, folder);
  for (const KeptTrace& kept : results.traces)
    PlotConfidenceTrace(kept.example.problem, kept.trace, folder + "/confidence.png");
}

void DrawFigures(const Report& report, const std::string& folder) {
  if (report.results.experiment.figures.curve) PlotCurve(report, folder);
  PlotBars(report, folder);
  PlotBudget(report, folder);
  PlotTime(report, folder);
  PlotReliability(report.results, folder);
  DrawExamples(report.results, folder);
}

}  // namespace diffsac
