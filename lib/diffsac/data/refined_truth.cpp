#include "diffsac/data/refined_truth.h"

#include "diffsac/data/pair_truth.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/refine.h"

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

}  // namespace diffsac
