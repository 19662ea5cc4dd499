#include "diffsac/eval/problem_quantities.h"

#include <algorithm>

#include "diffsac/geometry/pose.h"
#include "diffsac/problem/pair_truth.h"

namespace diffsac {
namespace {

constexpr double kUnknownQuantity = std::numeric_limits<double>::quiet_NaN();

double ShareWithin(const Example& example, double within_px) {
  const auto points = static_cast<double>(example.problem.points.rows());
  if (points == 0.0) return kUnknownQuantity;
  if (within_px > 0.0 && example.truth.assignment.empty() && IsTwoView(example.problem.task)) {
    const Eigen::VectorXd distances = TruthDistances(example.problem, example.truth);
    if (distances.size() > 0) return static_cast<double>((distances.array() <= within_px).count()) / points;
  }
  const auto& inliers = example.truth.inliers;
  if (inliers.empty()) return kUnknownQuantity;
  return static_cast<double>(std::count(inliers.begin(), inliers.end(), 1)) / points;
}

}  // namespace

void RecordQuantities(const Example& example, double within_px, ProblemRecord* record) {
  record->inlier_share = ShareWithin(example, within_px);
  if (!IsTwoView(example.problem.task)) return;
  const GroundTruth& truth = example.truth;
  if (truth.pose) record->true_rotation_deg = RotationAngleDegrees(truth.pose->rotation, Eigen::Matrix3d::Identity());
  if (truth.motion) record->true_baseline = truth.motion->translation.norm();
}

double QuantityOf(const ProblemRecord& record, Quantity quantity) {
  switch (quantity) {
    case Quantity::kInlierShare:
      return record.inlier_share;
    case Quantity::kPoints:
      return record.points;
    case Quantity::kRotation:
      return record.true_rotation_deg;
    case Quantity::kBaseline:
      return record.true_baseline;
    case Quantity::kScene:
      break;
  }
  return kUnknownQuantity;
}

const char* QuantityTitle(Quantity quantity) {
  switch (quantity) {
    case Quantity::kInlierShare:
      return "share of true inliers";
    case Quantity::kPoints:
      return "number of points";
    case Quantity::kRotation:
      return "true rotation in degrees";
    case Quantity::kBaseline:
      return "true baseline";
    case Quantity::kScene:
      break;
  }
  return "scene";
}

}  // namespace diffsac
