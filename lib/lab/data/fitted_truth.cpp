#include "lab/data/fitted_truth.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/sample_consensus.h"
#include "diffsac/ransac/samplers/minimal_sampler.h"
#include "lab/data/instance_sizes.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {
namespace {

constexpr int kDraws = 500, kFewest = 16;

ConsensusOptions Options() {
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMsac;
  options.local_optimization = LocalOptimization::kInnerSamples;
  options.max_iterations = kDraws;
  options.refit = Refit::kIterated;
  options.refit_rounds = 5;
  options.final_refinement = FinalRefinement::kRefinement;
  return options;
}

}  // namespace

std::optional<Matrix3Parameters> FitDominantPlane(const PointMatrix& points, double threshold_px, int fewest,
                                                  const Rng& rng) {
  UniformSampler source(static_cast<int>(points.rows()), Homography::kMinimalSize, rng.Fork("minimal_sets"));
  const ConsensusResult result = SampleConsensus<Homography>(points, threshold_px, source, Options(), rng);
  if (result.status != Status::kOk || std::count(result.inliers.begin(), result.inliers.end(), 1) < fewest) return {};
  return Matrix3Parameters(result.model);
}

std::optional<Eigen::Matrix3d> DominantHomography(const Problem& problem, const GroundTruth& truth, double threshold_px,
                                                  const std::string& id) {
  if (!truth.fundamental || truth.homography) return truth.homography;
  const Eigen::VectorXd distances = TruthDistances(problem, truth);
  std::vector<int> rows;
  for (int i = 0; i < distances.size(); ++i)
    if (distances[i] <= threshold_px && problem.points.row(i).allFinite()) rows.push_back(i);
  if (static_cast<int>(rows.size()) < kFewest) return {};
  const PointMatrix points = problem.points(rows, Eigen::all);
  const auto model = FitDominantPlane(points, threshold_px, kFewest, Rng(0).Fork("dominant_plane/" + id));
  return model ? std::optional(AsMatrix(*model)) : std::nullopt;
}

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

namespace {

// Empty where the matches fix none. A wrong label far off would lead the fit to all matches astray, so that the start
// is what most of them follow.
ModelParameters FitPlane(const PointMatrix& points, double loss_px) {
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(points.rows());
  if (points.rows() < FewestLabelled(Task::kHomography) || !Homography::Determined(points)) return {};
  const auto start = FitDominantPlane(points, loss_px, FewestLabelled(Task::kHomography), Rng(0).Fork("structure"));
  Matrix3Parameters model;
  if (start) {
    model = *start;
  } else if (!Homography::Fit(points, weights, &model)) {
    return {};
  }
  Homography::Refine(points, weights, {LossKind::kHuber, loss_px}, &model);
  return model;
}

ModelParameters FitMotion(const PointMatrix& points, double loss_px) {
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(points.rows());
  Matrix3Parameters model;
  if (points.rows() < FewestLabelled(Task::kFundamental) || !Fundamental::Determined(points) ||
      !Fundamental::Fit(points, weights, &model))
    return {};
  Fundamental::Refine(points, weights, {LossKind::kHuber, loss_px}, &model);
  return model;
}

}  // namespace

int FewestLabelled(Task task) {
  return 1 + (task == Task::kFundamental ? Fundamental::kMinimalSize : Homography::kMinimalSize);
}

void FitInstances(Task task, const Problem& problem, double loss_px, GroundTruth* truth) {
  truth->instances.clear();
  std::vector<std::vector<int>> rows;
  for (std::size_t i = 0; i < truth->assignment.size(); ++i) {
    const std::int32_t label = truth->assignment[i];
    if (label <= 0) continue;
    rows.resize(std::max(rows.size(), static_cast<std::size_t>(label)));
    rows[label - 1].push_back(static_cast<int>(i));
  }
  const auto fit = task == Task::kFundamental ? FitMotion : FitPlane;
  for (const std::vector<int>& instance : rows) {
    truth->instances.push_back(fit(problem.points(instance, Eigen::all), loss_px));
    if (truth->instances.back().size() > 0) continue;
    for (const int i : instance) truth->assignment[i] = 0;
  }
  ArrangeInstancesOf(task, truth);
}

void ArrangeInstancesOf(Task task, GroundTruth* truth) {
  ArrangeInstances(FewestLabelled(task), truth);
  auto& largest = task == Task::kFundamental ? truth->fundamental : truth->homography;
  largest.reset();
  if (!truth->instances.empty()) largest = AsMatrix(Matrix3Parameters(truth->model));
}

}  // namespace diffsac
