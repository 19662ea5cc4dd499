#include <algorithm>
#include <cmath>

#include "diffsac/eval/bootstrap.h"
#include "diffsac/eval/gnuplot.h"
#include "diffsac/eval/plot_texts.h"
#include "diffsac/eval/plots.h"

namespace diffsac {
namespace {

// One cluster of bars, one a row.
struct Cluster {
  std::string label;
  std::vector<ConfidenceInterval> bars;
};

ConfidenceInterval Height(const Report& report, std::size_t condition, std::size_t method, const ErrorOf& error_of) {
  const Cell* cell = report.results.Find(condition, method);
  if (cell == nullptr) return {std::nan(""), std::nan(""), std::nan("")};
  if (!error_of) return report.Of(*cell).accuracy;
  const Tolerance tolerance = report.results.experiment.tolerance();
  return BootstrapMean(SceneAccuracies(*cell, tolerance, error_of), BootstrapRng(report.results));
}

// Lines and planes: a cluster a condition. Poses: two a condition, rotation and translation.
std::vector<Cluster> Clusters(const Report& report, const std::vector<std::size_t>& rows) {
  const ExperimentResults& results = report.results;
  std::vector<Cluster> clusters;
  const bool poses = JudgesPoses(results);
  for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c) {
    const std::string label = results.experiment.conditions[c].label;
    const auto add = [&](const std::string& name, const ErrorOf& error_of) {
      Cluster cluster{name, {}};
      for (const std::size_t row : rows) cluster.bars.push_back(Height(report, c, row, error_of));
      const bool known = std::any_of(cluster.bars.begin(), cluster.bars.end(),
                                     [](const ConfidenceInterval& bar) { return !std::isnan(bar.mean); });
      if (known) clusters.push_back(std::move(cluster));
    };
    if (poses) {
      add(label + ", R", [](const EstimateError& error) { return error.rotation_deg; });
      add(label + ", t", [](const EstimateError& error) { return error.translation_deg; });
    } else {
      add(label, {});
    }
  }
  return clusters;
}

std::string Data(const std::vector<Cluster>& clusters) {
  std::string text = "$bars << EOD\n";
  for (const Cluster& cluster : clusters) {
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
  std::vector<std::size_t> rows;
  for (const std::string& name : experiment.figures.bars) rows.push_back(experiment.RowOf(name));
  const std::vector<Cluster> clusters = Clusters(report, rows);
  if (rows.empty() || clusters.empty()) return false;
  std::string script = Data(clusters) + "set title " + GnuplotText(PlotTitle(results)) + " font \",13\"\n" +
                       AccuracyAxes(results, experiment.condition_label) +
                       "set yrange [0:1]\nset grid noxtics\nset style data histograms\n"
                       "set style histogram errorbars gap 1.5 lw 1\nset style fill solid 0.85 border -1\nset bars 0.4\n"
                       "set key outside right center samplen 1.5 spacing 1.2\nplot ";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string mean = std::to_string(2 + 3 * i), low = std::to_string(3 + 3 * i), high = std::to_string(4 + 3 * i);
    script += (i == 0 ? "" : ", \\\n  ") + ("$bars using " + mean + ":" + low + ":" + high) +
              (i == 0 ? ":xtic(1)" : "") + " lc rgb \"" + SeriesColour(i) + "\"" +
              (i < kSeriesColours ? "" : " fs pattern 5 border -1") + " title " +
              GnuplotText(experiment.methods[rows[i]].label);
  }
  const auto bars = static_cast<int>(rows.size() * clusters.size());
  return DrawPicture(folder, "bars", script + "\n", std::clamp(380 + 22 * bars, 720, 1800), 480);
}

}  // namespace diffsac
