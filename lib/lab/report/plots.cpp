#include "lab/report/plots.h"

#include <algorithm>
#include <iterator>

#include "diffsac/core/files.h"
#include "lab/eval/problem_quantities.h"
#include "lab/report/colours.h"
#include "lab/report/gnuplot.h"
#include "lab/report/plot_series.h"
#include "lab/report/plot_texts.h"

namespace diffsac {
namespace {

std::string Block(const std::string& name, const std::vector<CurvePoint>& points) {
  std::string text = "$" + name + " << EOD\n";
  for (const CurvePoint& point : points) text += GnuplotNumber(point.x) + " " + GnuplotNumber(point.y) + "\n";
  return text + "EOD\n";
}

// Colours repeat after seven series, with other dashes; the marks do not before fourteen. The dotted line is that of
// references.
std::string SeriesStyle(std::size_t index, bool strong) {
  static constexpr int kMarks[] = {7, 5, 9, 11, 13, 15, 3, 4, 6, 12, 8, 10, 14, 2};
  static constexpr int kDashes[] = {1, 2, 4, 5};
  return "with linespoints dt " + std::to_string(kDashes[index / kSeriesColours % std::size(kDashes)]) + " lc rgb \"" +
         std::string(SeriesColour(index)) + "\" lw " + (strong ? "3" : "2") + " pt " +
         std::to_string(kMarks[index % std::size(kMarks)]) + " ps 1.2";
}

// Of a key that holds these labels, in pixels.
int KeyWidth(const std::vector<Curve>& curves) {
  constexpr int kLeast = 260, kMark = 80, kLetter = 8;
  int width = kLeast;
  for (const Curve& curve : curves) width = std::max(width, kMark + kLetter * static_cast<int>(curve.label.size()));
  return width;
}

constexpr const char* kCeilingStyle = "with lines dt 2 lw 2 lc rgb \"#000000\"";
constexpr const char* kReferenceStyle = "with lines dt 3 lw 2 lc rgb \"#666666\"";

std::string StyleOf(const Curve& curve) {
  if (curve.kind == CurveKind::kCeiling) return kCeilingStyle;
  if (curve.kind == CurveKind::kReference) return kReferenceStyle;
  return SeriesStyle(curve.colour, curve.kind == CurveKind::kStrong);
}

std::string PlotCommand(const std::string& prefix, const std::vector<Curve>& curves) {
  std::string blocks, command = "plot ";
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const std::string name = prefix + std::to_string(i);
    blocks += Block(name, curves[i].points);
    command += (i == 0 ? "" : ", \\\n  ") + ("$" + name) + " using 1:2 " + StyleOf(curves[i]) + " title " +
               GnuplotText(curves[i].label);
  }
  return blocks + command + "\n";
}

// A panel a condition beside each other. They share one key, beside them so that it hides no curve. `axes`: commands
// for all of them; `before(condition)`: for one.
template <class Before>
bool DrawPanels(const Report& report, const std::string& folder, const std::string& name,
                const std::vector<CurvePanel>& panels, const std::string& axes, const Before& before) {
  const ExperimentResults& results = report.results;
  std::size_t richest = 0;
  for (std::size_t i = 0; i < panels.size(); ++i)
    if (panels[i].curves.size() > panels[richest].curves.size()) richest = i;
  if (panels.empty()) return false;
  const int count = static_cast<int>(panels.size()), key = KeyWidth(panels[richest].curves);
  const int width = 80 + 380 * count + key;
  const double right = 1.0 - static_cast<double>(key) / width, left = 70.0 / width;
  std::string script = "set multiplot layout 1," + std::to_string(count) + " title " + GnuplotText(PlotTitle(results)) +
                       " font \",13\" margins " + GnuplotNumber(left) + "," + GnuplotNumber(right) +
                       ",0.16,0.85 spacing " + GnuplotNumber(left) + "\n" + axes + "set yrange [0:1]\n";
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const Condition& condition = results.experiment.conditions[panels[i].condition];
    script += (i == richest ? "set key at screen 0.995, screen 0.85 right top samplen 4\n" : "unset key\n") +
              ("set title " + GnuplotText(results.experiment.condition_label + ": " + condition.label)) + "\n" +
              before(panels[i].condition) +
              PlotCommand(name + std::to_string(panels[i].condition) + "_", panels[i].curves);
  }
  return DrawPicture(folder, name, script + "unset multiplot\n", width, 480);
}

// `cost`: the metric on the x axis.
bool PlotCost(const Report& report, const std::string& folder, const std::string& cost, const std::string& x_label,
              const std::string& name) {
  const std::string axes = AccuracyAxes(report.results, x_label) + "set logscale x\n";
  return DrawPanels(report, folder, name, CostPanels(report, cost), axes, [](std::size_t) { return ""; });
}

// The names of a division's bins, with their problems on a line below.
std::string BinTics(const StrataReport& strata, std::size_t condition) {
  std::string tics;
  for (std::size_t i = 0; i < strata.strata.size(); ++i) {
    const Stratum& stratum = strata.strata[i].stratum;
    std::string label = GnuplotText(stratum.label);
    label.insert(label.size() - 1, "\\n" + std::to_string(stratum.problems[condition]));
    tics += (tics.empty() ? "" : ", ") + label + " " + std::to_string(i);
  }
  return "set xlabel offset 0, -0.8\nset xtics (" + tics +
         ") font \",9\"\nset xrange [-0.3:" + GnuplotNumber(strata.strata.size() - 0.7) + "]\n";
}

// An earlier run's picture must not stand for one that this run has not.
void Keep(bool drawn, const std::string& folder, const std::string& name) {
  if (!drawn) RemoveFile(folder + "/" + name + ".png");
}

void DrawStrata(const Report& report, Quantity quantity, const std::string& folder) {
  bool drawn = false;
  for (const StrataReport& strata : report.strata)
    if (strata.options.by == quantity) drawn = PlotStrata(report, strata, folder);
  Keep(drawn, folder, StrataPicture(quantity));
}

}  // namespace

bool PlotCurve(const Report& report, const std::string& folder) {
  const ExperimentResults& results = report.results;
  const std::vector<Curve> curves = ConditionCurves(report);
  if (curves.empty()) return false;
  const std::string script = "set title " + GnuplotText(PlotTitle(results)) + " font \",13\"\n" +
                             AccuracyAxes(results, results.experiment.condition_label) +
                             "set key outside right center samplen 4 spacing 1.2\nset yrange [0:1]\n" +
                             "set offsets graph 0.02, graph 0.02, 0, 0\n" + PlotCommand("curve", curves);
  return DrawPicture(folder, "curve", script, 1100, 640);
}

bool PlotBudget(const Report& report, const std::string& folder) {
  return PlotCost(report, folder, "hypotheses", "hypotheses (models solved or scored)", "budget");
}

bool PlotTime(const Report& report, const std::string& folder) {
  return PlotCost(report, folder, "ms_total", "milliseconds (median)", "time");
}

std::string StrataPicture(Quantity quantity) { return "strata_" + ToString(quantity); }

bool PlotStrata(const Report& report, const StrataReport& strata, const std::string& folder) {
  if (!strata.known()) return false;
  const std::string x_label = std::string(QuantityTitle(strata.options.by)) + ", and problems";
  return DrawPanels(report, folder, StrataPicture(strata.options.by), StrataPanels(report, strata),
                    AccuracyAxes(report.results, x_label),
                    [&](std::size_t condition) { return BinTics(strata, condition); });
}

void DrawExamples(const ExperimentResults& results, const std::string& folder) {
  PlotFits(results, folder);
  PlotMatches(results, folder);
  for (const KeptTrace& kept : results.traces)
    PlotConfidenceTrace(kept.example.problem, kept.trace, folder + "/confidence.png");
}

void DrawFigures(const Report& report, const std::string& folder) {
  Keep(report.results.experiment.figures.curve && PlotCurve(report, folder), folder, "curve");
  Keep(PlotBars(report, folder), folder, "bars");
  Keep(PlotBudget(report, folder), folder, "budget");
  Keep(PlotTime(report, folder), folder, "time");
  Keep(PlotReliability(report.results, folder), folder, "reliability");
  Keep(PlotEffects(report, folder), folder, "effects");
  for (const std::string& quantity : NamesOf<Quantity>()) DrawStrata(report, FromString<Quantity>(quantity), folder);
  DrawExamples(report.results, folder);
}

}  // namespace diffsac
