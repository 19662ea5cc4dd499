#include <cmath>

#include "lab/report/colours.h"
#include "lab/report/effect_tables.h"
#include "lab/report/gnuplot.h"
#include "lab/report/plot_series.h"
#include "lab/report/plot_texts.h"
#include "lab/report/plots.h"

namespace diffsac {
namespace {

constexpr double kBetweenConditions = 0.18;  // Of a level's line.

/// Where the levels stand, from above: a line each, and one for the factor's name before its levels.
std::vector<double> HeightsOf(const std::vector<FactorLevel>& levels) {
  std::vector<double> heights;
  for (std::size_t i = 0; i < levels.size(); ++i) heights.push_back(static_cast<double>(i + levels[i].factor + 1));
  return heights;
}

/// Lines for the levels, with their names (beside the left panel) or without.
std::string LevelTics(const ExperimentOptions& experiment, const std::vector<FactorLevel>& levels,
                      const std::vector<double>& heights, bool named) {
  std::string tics;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const std::string& name = experiment.factors[levels[i].factor].second[levels[i].level];
    tics += (i == 0 ? "" : ", ") + GnuplotText(named ? name : "") + " " + GnuplotNumber(heights[i]);
  }
  return "set ytics (" + tics + ")\n";
}

/// The factors' names, each before its levels.
std::string FactorLabels(const ExperimentOptions& experiment, const std::vector<FactorLevel>& levels,
                         const std::vector<double>& heights) {
  std::string text;
  for (std::size_t i = 0; i < levels.size(); ++i)
    if (levels[i].level == 0)
      text += "set label " + GnuplotText(experiment.factors[levels[i].factor].first) + " at screen 0.02, first " +
              GnuplotNumber(heights[i] - 0.8) + "\n";
  return text;
}

/// One condition's dots; the first level's has no interval, for it is what the others are held against.
std::string Dots(const std::vector<FactorLevel>& levels, const std::vector<double>& heights,
                 const FactorEffects& effects, EffectPart part, double shift) {
  const double none = part == &LevelEffect::accuracy ? 0.0 : 1.0;
  std::string text;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const auto& effect = effects[levels[i].factor][levels[i].level].*part;
    if (!effect) continue;
    const ConfidenceInterval shown = levels[i].level == 0 ? ConfidenceInterval{none, none, none} : *effect;
    text += GnuplotNumber(heights[i] + shift);
    for (const double value : {shown.mean, shown.low, shown.high}) text += " " + GnuplotNumber(value);
    text += "\n";
  }
  return text;
}

/// The panel of one part: a block of dots a condition. Empty where there are none.
std::string EffectPanel(const Report& report, const std::vector<std::size_t>& conditions, EffectPart part,
                        const std::string& name) {
  const ExperimentOptions& experiment = report.results.experiment;
  const std::vector<FactorLevel> levels = LevelsOf(experiment);
  const std::vector<double> heights = HeightsOf(levels);
  std::string blocks, plots;
  for (std::size_t i = 0; i < conditions.size(); ++i) {
    const double shift = kBetweenConditions * (static_cast<double>(i) - (conditions.size() - 1) / 2.0);
    const std::string dots = Dots(levels, heights, report.effects[conditions[i]], part, shift),
                      block = "$" + name + std::to_string(i);
    if (dots.empty()) continue;
    blocks += block + " << EOD\n" + dots + "EOD\n";
    plots += (plots.empty() ? "plot " : ", \\\n  ") + block +
             " using 2:1:3:4 with xerrorbars pt 7 ps 1 lw 2 lc rgb \"" + SeriesColour(i) + "\" title " +
             GnuplotText(experiment.conditions[conditions[i]].label);
  }
  return plots.empty() ? "" : blocks + plots + "\n";
}

}  // namespace

bool PlotEffects(const Report& report, const std::string& folder) {
  const ExperimentOptions& experiment = report.results.experiment;
  if (experiment.factors.empty()) return false;
  std::vector<std::size_t> conditions;
  for (std::size_t c = 0; c < experiment.conditions.size(); ++c) conditions.push_back(c);
  conditions = EvenlyChosen(conditions);
  const std::string accuracy = EffectPanel(report, conditions, &LevelEffect::accuracy, "accuracy"),
                    milliseconds = EffectPanel(report, conditions, &LevelEffect::milliseconds, "ms");
  if (accuracy.empty() || milliseconds.empty()) return false;
  const std::vector<FactorLevel> levels = LevelsOf(experiment);
  const std::vector<double> heights = HeightsOf(levels);
  const int height = 170 + static_cast<int>(26.0 * (heights.back() + 1.0));
  const std::string script =
      "set multiplot layout 1,2 title " + GnuplotText(PlotTitle(report.results)) + " font \",13\" margins 0.22,0.97," +
      GnuplotNumber(60.0 / height) + "," + GnuplotNumber(1.0 - 60.0 / height) +
      " spacing 0.03\nset grid ls 100\nset tics nomirror\nset bars 0.5\nset yrange [" +
      GnuplotNumber(heights.back() + 0.7) + ":-0.5]\n" + LevelTics(experiment, levels, heights, true) +
      FactorLabels(experiment, levels, heights) + "set arrow 1 from 0, graph 0 to 0, graph 1 nohead dt 2\n" +
      "set key at screen 0.99, screen 0.99 right top maxrows 2 samplen 1\nset xlabel " +
      GnuplotText(AccuracyTitle(report.results) + " minus the first level's") + "\n" + accuracy +
      "unset key\nunset label\nset logscale x\n" + LevelTics(experiment, levels, heights, false) +
      "set arrow 1 from 1, graph 0 to 1, graph 1 nohead dt 2\n" +
      "set xlabel \"milliseconds over the first level's\"\n" + milliseconds + "unset multiplot\n";
  return DrawPicture(folder, "effects", script, 1000, height);
}

}  // namespace diffsac
