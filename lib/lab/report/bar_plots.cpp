#include <algorithm>

#include "lab/report/colours.h"
#include "lab/report/gnuplot.h"
#include "lab/report/plot_series.h"
#include "lab/report/plot_texts.h"
#include "lab/report/plots.h"

namespace diffsac {
namespace {

std::string Data(const std::vector<BarCluster>& clusters) {
  std::string text = "$bars << EOD\n";
  for (const BarCluster& cluster : clusters) {
    text += GnuplotText(cluster.label);
    for (const ConfidenceInterval& bar : cluster.bars)
      text += " " + GnuplotNumber(bar.mean) + " " + GnuplotNumber(bar.low) + " " + GnuplotNumber(bar.high);
    text += "\n";
  }
  return text + "EOD\n";
}

}  // namespace

bool PlotBars(const Report& report, const std::string& folder) {
  const ExperimentResults& results = report.results;
  const ExperimentOptions& experiment = results.experiment;
  const std::vector<std::size_t> rows = BarRows(experiment);
  const std::vector<BarCluster> clusters = BarClusters(report, rows);
  if (rows.empty() || clusters.empty()) return false;
  std::string script = Data(clusters) + "set title " + GnuplotText(PlotTitle(results)) + " font \",13\"\n" +
                       AccuracyAxes(results, experiment.condition_label) +
                       "set yrange [0:1]\nset grid noxtics\nset style data histograms\n"
                       "set style histogram errorbars gap 1.5 lw 1\nset style fill solid 0.85 border -1\nset bars 0.4\n"
                       "set key outside right center samplen 1.5 spacing 1.2\nplot ";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string mean = std::to_string(2 + 3 * i), low = std::to_string(3 + 3 * i),
                      high = std::to_string(4 + 3 * i);
    script += (i == 0 ? "" : ", \\\n  ") + ("$bars using " + mean + ":" + low + ":" + high) +
              (i == 0 ? ":xtic(1)" : "") + " lc rgb \"" + SeriesColour(i) + "\"" +
              (i < kSeriesColours ? "" : " fs pattern 5 border -1") + " title " +
              GnuplotText(experiment.methods[rows[i]].label);
  }
  const auto bars = static_cast<int>(rows.size() * clusters.size());
  return DrawPicture(folder, "bars", script + "\n", std::clamp(380 + 22 * bars, 720, 1800), 480);
}

}  // namespace diffsac
