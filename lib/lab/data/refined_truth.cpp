#include "lab/data/refined_truth.h"

#include <algorithm>
#include <limits>

#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/refine.h"
#include "lab/truth/pair_truth.h"

namespace diffsac {
namespace {

constexpr Eigen::Index kFewestNear = 16;

// The refined F in pixels; false when the refinement failed.
bool Refine(const Problem& problem, const Eigen::VectorXd& weights, double loss_px, Matrix3Parameters* model) {
  RefineOptions options;
  options.loss.scale = loss_px;
  if (!problem.cameras) return RefineFundamental(problem.points, weights, options, model).status == Status::kOk;
  const auto& [K1, K2] = *problem.cameras;
  options.loss.scale /= problem.cameras->MeanFocal();
  Matrix3Parameters essential = AsParameters(EssentialFromFundamental(AsMatrix(*model), K1, K2));
  const PointMatrix points = NormalizedCoordinates(problem.points, K1, K2);
  if (RefineEssential(points, weights, options, &essential).status != Status::kOk) return false;
  *model = AsParameters(FundamentalFromEssential(AsMatrix(essential), K1, K2));
  return true;
}

Eigen::Index CountNear(const Problem& problem, const GroundTruth& truth, double loss_px) {
  return (TruthDistances(problem, truth).array() <= loss_px).count();
}

}  // namespace

void RefineEpipolarTruth(const Problem& problem, double loss_px, GroundTruth* truth) {
  if (truth->homography || !truth->fundamental) return;
  const Eigen::ArrayXd distances = TruthDistances(problem, *truth);
  const Eigen::VectorXd near = (distances <= 2.0 * loss_px).cast<double>();
  if (near.sum() < static_cast<double>(kFewestNear)) return;
  Matrix3Parameters model = AsParameters(*truth->fundamental);
  if (!Refine(problem, near, loss_px, &model) || !model.allFinite()) return;
  GroundTruth refined;
  refined.fundamental = AsMatrix(model);
  const Eigen::ArrayXd after = TruthDistances(problem, refined);
  if ((after <= loss_px).count() < (distances <= loss_px).count()) return;
  truth->fundamental = refined.fundamental;
  if (problem.cameras)
    truth->essential = EssentialFromFundamental(*refined.fundamental, problem.cameras->K1, problem.cameras->K2);
}

double TruthDisagreementDegrees(const Problem& problem, const GroundTruth& truth, double loss_px, int near) {
  constexpr int kRounds = 3;  // The matches that are near change with the pose.
  if (!truth.motion || !problem.cameras) return std::numeric_limits<double>::quiet_NaN();
  GroundTruth refined = truth;
  CompleteTruth(problem, &refined);
  for (int round = 0; round < kRounds; ++round) {
    if (CountNear(problem, refined, loss_px) < near) return std::numeric_limits<double>::infinity();
    RefineEpipolarTruth(problem, loss_px, &refined);
  }
  if (CountNear(problem, refined, loss_px) < near) return std::numeric_limits<double>::infinity();
  double least = std::numeric_limits<double>::infinity();
  for (const RelativePose& pose : DecomposeEssential(*refined.essential))
    least = std::min(least, std::max(RotationAngleDegrees(pose.rotation, truth.motion->rotation),
                                     DirectionAngleDegrees(pose.translation, truth.motion->translation)));
  return least;
}

}  // namespace diffsac
