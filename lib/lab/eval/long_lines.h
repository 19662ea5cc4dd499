#pragma once

#include <string>
#include <vector>

#include "lab/eval/report.h"

namespace diffsac {

/// A number as files have it, with nine digits; empty where it is unknown or not finite.
std::string NumberText(double value);

/// The lines of results.csv: experiment,dataset,scene,condition,method,metric,value.
class LongLines {
 public:
  explicit LongLines(const ExperimentResults& results);
  void Add(const std::string& scene, std::size_t condition, const std::string& method, const std::string& metric,
           double value);
  /// The mean under the metric's name and, where they are known, the ends under METRIC_low and METRIC_high.
  void Add(const std::string& scene, std::size_t condition, const std::string& method, const std::string& metric,
           const ConfidenceInterval& interval);
  const ExperimentResults& results() const { return results_; }
  /// AccuracyMetric.
  const std::string& accuracy() const { return accuracy_; }
  const std::string& text() const { return text_; }

 private:
  const ExperimentResults& results_;
  std::string accuracy_;
  std::string text_ = "experiment,dataset,scene,condition,method,metric,value\n";
};

/// Effects by condition: "FACTOR=LEVEL" in the method's place, the accuracy's metric and `ms` with their ends, and
/// `combinations`.
void AddEffectLines(const std::vector<FactorEffects>& effects, const std::string& scene, LongLines* lines);

/// For each stratum, its name in the scene's place: of each row the accuracy with its ends, problems and failures; the
/// comparisons, "A - B" in the method's place; the effects.
void AddStrataLines(const Report& report, LongLines* lines);

}  // namespace diffsac
