#pragma once

#include <string>

#include "lab/eval/results.h"
#include "lab/report/gnuplot.h"

namespace diffsac {

/// The experiment's title, or its name; says when results are partial.
inline std::string PlotTitle(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  return (experiment.title.empty() ? experiment.name : experiment.title) + (results.partial ? " (partial)" : "");
}

/// Labels and grid of a picture whose y axis is mAA, as gnuplot commands.
inline std::string AccuracyAxes(const ExperimentResults& results, const std::string& x_label) {
  return "set xlabel " + GnuplotText(x_label) + "\nset ylabel " + GnuplotText(AccuracyTitle(results)) +
         "\nset grid ls 100\nset tics nomirror\n";
}

}  // namespace diffsac
