#include "lab/eval/reliability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lab/eval/format.h"

namespace diffsac {
namespace {

/// Of the scenes with points in the bin, the mean of one of its sums over its points.
double MeanOverScenes(const ReliabilityCurve& curve, int bin, double Reliability::Bin::*sum) {
  double total = 0.0, scenes = 0.0;
  for (const auto& [scene, reliability] : curve.scenes) {
    const Reliability::Bin& counted = reliability.bins()[static_cast<std::size_t>(bin)];
    if (!(counted.points > 0.0)) continue;
    total += counted.*sum / counted.points;
    scenes += 1.0;
  }
  return scenes > 0.0 ? total / scenes : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

void Reliability::Add(std::span<const float> probabilities, std::span<const std::uint8_t> inliers) {
  if (probabilities.size() != inliers.size()) return;
  for (std::size_t i = 0; i < inliers.size(); ++i) {
    const double p = probabilities[i];
    if (!(p >= 0.0 && p <= 1.0)) continue;
    Bin& bin = bins_[static_cast<std::size_t>(std::min(kBins - 1, static_cast<int>(p * kBins)))];
    bin.points += 1.0;
    bin.predicted += p;
    bin.inliers += inliers[i] != 0 ? 1.0 : 0.0;
  }
}

void Reliability::Add(const Reliability& other) {
  for (int b = 0; b < kBins; ++b) Add(b, other.bins_[static_cast<std::size_t>(b)]);
}

void Reliability::Add(int bin, const Bin& other) {
  Bin& own = bins_[static_cast<std::size_t>(bin)];
  own.points += other.points;
  own.predicted += other.predicted;
  own.inliers += other.inliers;
}

bool Reliability::empty() const {
  return std::all_of(bins_.begin(), bins_.end(), [](const Bin& bin) { return bin.points == 0.0; });
}

double Reliability::CalibrationError() const {
  double wrong = 0.0, points = 0.0;
  for (const Bin& bin : bins_) {
    wrong += std::abs(bin.inliers - bin.predicted);
    points += bin.points;
  }
  return points > 0.0 ? wrong / points : std::numeric_limits<double>::quiet_NaN();
}

double ReliabilityCurve::Share(int bin) const { return MeanOverScenes(*this, bin, &Reliability::Bin::inliers); }

double ReliabilityCurve::Predicted(int bin) const { return MeanOverScenes(*this, bin, &Reliability::Bin::predicted); }

double ReliabilityCurve::CalibrationError() const {
  double total = 0.0;
  for (const auto& [scene, reliability] : scenes) total += reliability.CalibrationError();
  return total / static_cast<double>(scenes.size());
}

std::vector<ReliabilityCurve> DistinctCurves(const std::vector<ReliabilityCurve>& curves) {
  std::vector<ReliabilityCurve> distinct;
  for (const bool ratio : {false, true})
    for (const ReliabilityCurve& curve : curves) {
      if ((curve.label == kRatioLabel) != ratio) continue;
      const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const ReliabilityCurve& other) {
        const bool both_ratio = ratio && other.label == kRatioLabel;
        return other.condition == curve.condition && (both_ratio || other.scenes == curve.scenes);
      });
      if (!known) distinct.push_back(curve);
    }
  std::stable_sort(distinct.begin(), distinct.end(),
                   [](const ReliabilityCurve& a, const ReliabilityCurve& b) { return a.condition < b.condition; });
  return distinct;
}

void AddCurves(const std::vector<ReliabilityCurve>& others, std::vector<ReliabilityCurve>* curves) {
  for (const ReliabilityCurve& other : others) {
    auto own = std::find_if(curves->begin(), curves->end(), [&](const ReliabilityCurve& curve) {
      return curve.label == other.label && curve.condition == other.condition;
    });
    if (own == curves->end()) own = curves->insert(own, {other.label, other.condition, {}});
    for (const auto& [scene, reliability] : other.scenes) own->scenes[scene].Add(reliability);
  }
}

std::string ReliabilityCsv(const std::vector<ReliabilityCurve>& curves, const std::vector<std::string>& conditions) {
  std::string text = "method,condition,scene,low,high,points,predicted,inliers\n";
  for (const ReliabilityCurve& curve : curves) {
    const std::string names = CsvText(curve.label) + "," + CsvText(conditions[curve.condition]) + ",";
    for (int b = 0; b < Reliability::kBins; ++b) {
      const std::string range = Format("%.1f,%.1f,", 0.1 * b, 0.1 * (b + 1));
      double points = 0.0;
      for (const auto& [scene, reliability] : curve.scenes) {
        const Reliability::Bin& bin = reliability.bins()[static_cast<std::size_t>(b)];
        points += bin.points;
        if (bin.points > 0.0)
          text += names + CsvText(scene) + "," + range +
                  Format("%.0f,%.4f,%.4f\n", bin.points, bin.predicted / bin.points, bin.inliers / bin.points);
      }
      if (points > 0.0)
        text += names + "mean," + range + Format("%.0f,%.4f,%.4f\n", points, curve.Predicted(b), curve.Share(b));
    }
    text += names + "calibration_error,,,," + Format("%.4f,\n", curve.CalibrationError());
  }
  return text;
}

}  // namespace diffsac
