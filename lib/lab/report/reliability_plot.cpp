#include "lab/report/colours.h"
#include "lab/report/gnuplot.h"
#include "lab/report/plot_series.h"
#include "lab/report/plot_texts.h"
#include "lab/report/plots.h"

namespace diffsac {
namespace {

std::string BlockName(std::size_t condition, std::size_t curve) {
  return "$r" + std::to_string(condition) + "_" + std::to_string(curve);
}

/// One panel: the diagonal, and a line for each curve of the condition.
std::string Panel(const ExperimentResults& results, const std::vector<ReliabilityCurve>& curves,
                  std::size_t condition) {
  std::string data, plot = "plot x with lines lc rgb \"#999999\" dt 2 notitle";
  std::size_t shown = 0;
  for (const ReliabilityCurve& curve : curves) {
    if (curve.condition != condition) continue;
    const std::string block = BlockName(condition, shown);
    data += block + " << EOD\n";
    for (int b = 0; b < Reliability::kBins; ++b)
      data += GnuplotNumber(curve.Predicted(b)) + " " + GnuplotNumber(curve.Share(b)) + "\n";
    data += "EOD\n";
    plot += ", \\\n  " + block + " using 1:2 with linespoints pt 7 ps 0.7 lw 2 lc rgb \"" + SeriesColour(shown++) +
            "\" title " + GnuplotText(curve.label);
  }
  const Condition& shown_condition = results.experiment.conditions[condition];
  return data + "set title " + GnuplotText(results.experiment.condition_label + ": " + shown_condition.label) + "\n" +
         plot + "\n";
}

}  // namespace

bool PlotReliability(const ExperimentResults& results, const std::string& folder) {
  const std::vector<ReliabilityCurve> curves = DistinctCurves(results.reliability);
  std::vector<std::size_t> conditions;
  for (const ReliabilityCurve& curve : curves)
    if (conditions.empty() || conditions.back() != curve.condition) conditions.push_back(curve.condition);
  if (conditions.empty()) return false;
  conditions = EvenlyChosen(conditions);
  const int count = static_cast<int>(conditions.size()), width = 60 + 460 * count;
  std::string script =
      "set multiplot layout 1," + std::to_string(count) + " title " +
      "\"How often a point is an inlier, by its probability\\n" + GnuplotText(PlotTitle(results)).substr(1) +
      " font \",12\"\nset xrange [0:1]\nset yrange [0:1]\nset size square\nset grid ls 100\n" +
      "set xlabel \"probability\" offset 0,0.5\nset ylabel \"share of true inliers, mean over scenes\"\n" +
      "set key below center Left reverse maxcols 1 samplen 2 width -8\n";
  for (const std::size_t condition : conditions) script += Panel(results, curves, condition);
  return DrawPicture(folder, "reliability", script + "unset multiplot\n", width, 560);
}

}  // namespace diffsac
