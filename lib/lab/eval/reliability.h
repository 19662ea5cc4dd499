#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace diffsac {

/// How often what is said to be an inlier with a probability is one: points counted in ten bins of that probability.
class Reliability {
 public:
  static constexpr int kBins = 10;
  struct Bin {
    double points = 0.0;     ///< How many.
    double predicted = 0.0;  ///< Sum of their probabilities.
    double inliers = 0.0;    ///< How many are inliers.
    bool operator==(const Bin&) const = default;
  };

  /// One problem: probabilities in [0, 1], and for each point whether it is a true inlier. Nothing is counted where the
  /// lengths differ (no truth, or no probabilities).
  void Add(std::span<const float> probabilities, std::span<const std::uint8_t> inliers);
  void Add(const Reliability& other);
  /// The bins of another process.
  void Add(int bin, const Bin& other);

  const std::array<Bin, kBins>& bins() const { return bins_; }
  bool empty() const;
  /// The expected calibration error: |share of inliers − mean probability| of the bins, weighed by their points
  /// (Naeini, Cooper, Hauskrecht, "Obtaining well calibrated probabilities using Bayesian binning", AAAI 2015).
  double CalibrationError() const;
  bool operator==(const Reliability&) const = default;

 private:
  std::array<Bin, kBins> bins_{};
};

/// The probabilities of one row, or those by the matching ratio, on one condition.
struct ReliabilityCurve {
  std::string label;
  std::size_t condition = 0;
  std::map<std::string, Reliability> scenes;

  /// The unweighted mean of the scenes' shares in a bin, of those scenes that have points there; NaN without any.
  double Share(int bin) const;
  double Predicted(int bin) const;
  /// The unweighted mean over the scenes.
  double CalibrationError() const;
};

/// The label of the curve of the probabilities by the matching ratio, on the problems of a row with a network.
inline constexpr const char* kRatioLabel = "by the matching ratio";

/// Those to show: of a condition each once, and the ratio's last; rows of the same network say the same.
std::vector<ReliabilityCurve> DistinctCurves(const std::vector<ReliabilityCurve>& curves);

/// Adds another shard's curves to those of the same label and condition.
void AddCurves(const std::vector<ReliabilityCurve>& others, std::vector<ReliabilityCurve>* curves);

/// reliability.csv: method,condition,scene,low,high,points,predicted,inliers (shares); scene "mean" is the unweighted
/// mean, and a line `calibration_error` a method and condition.
std::string ReliabilityCsv(const std::vector<ReliabilityCurve>& curves, const std::vector<std::string>& conditions);

}  // namespace diffsac
