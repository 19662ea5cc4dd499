#include "diffsac/estimate/focal_conflict.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/focal_evidence.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/geometry/robust_loss_sums.h"
#include "diffsac/geometry/svd3.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

/// Nothing is known of the lengths: their deviation, of log f, beside which what the matches say is all.
constexpr FocalPriors kOpen = {FocalPrior{1.0, 2.0}, FocalPrior{1.0, 2.0}};

/// What was said, in the solver's coordinates, in which said lengths are 1.
struct Said {
  std::vector<UnknownFocal> open;  ///< The lengths that may be others; what is tried.
  PointMatrix points;
  double unit;  ///< Pixels.
  FocalParameters model;
  std::array<double, 2> px;  ///< Of either image of the solver's.
  Eigen::Matrix2d spread;    ///< Of log f.
  bool swapped = false;
};

Said SaidOfCalibrations(const NormalizedProblem& solved, const Estimate& estimate) {
  const CameraPair& cameras = *solved.problem().cameras;
  return {{UnknownFocal::kBoth},
          solved.points(),
          solved.unit(),
          AsFocalParameters(Matrix3Parameters(estimate.model), 1.0, 1.0),
          {FocalOf(cameras.K1), FocalOf(cameras.K2)},
          Eigen::Matrix2d::Zero()};
}

Said SaidOfPriors(UnknownFocal unknown, const NormalizedProblem& solved, const Estimate& estimate) {
  constexpr double kOneLength = 0.05;
  const FocalSpace space = FocalSpaceOf(unknown, solved.problem()).value();
  Said said{{unknown},  solved.points(),         solved.unit(), FocalParameters(estimate.model),
            space.unit, Eigen::Matrix2d::Zero(), space.swapped};
  const auto& sigmas = estimate.focal->prior_log_sigma;
  for (int k = 0; k < 2; ++k) said.spread(k, k) = std::pow(sigmas[space.swapped ? 1 - k : k], 2);
  if (unknown != UnknownFocal::kBoth) return said;
  // Two images that are said to have one length may have two.
  said.open.push_back(UnknownFocal::kEach);
  said.spread.setConstant(said.spread(0, 0));
  said.spread += kOneLength * kOneLength * Eigen::Matrix2d::Identity();
  return said;
}

std::optional<Said> SaidOf(const NormalizedProblem& solved, const Estimate& estimate) {
  const Task task = solved.problem().task;
  if (task == Task::kEssential) return SaidOfCalibrations(solved, estimate);
  return DispatchDescription(task, [&]<class Description>() -> std::optional<Said> {
    if constexpr (requires { Description::kUnknownFocal; })
      if (estimate.focal) return SaidOfPriors(Description::kUnknownFocal, solved, estimate);
    return std::nullopt;
  });
}

double CostOf(const FocalParameters& model, const PointMatrix& points, const RobustLoss& loss) {
  const Matrix3Parameters f = FundamentalOf(model);
  double cost = 0.0;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    cost += std::min(std::pow(SampsonError(f, points.row(i).data()), 2), loss.scale * loss.scale);
  return cost;
}

/// E and the lengths that explain most matches, from the model on. With lengths that are wrong a part of them fits, of
/// which some pull where more do.
bool Free(UnknownFocal open, const Said& said, const RobustLoss& loss, FocalParameters* model) {
  constexpr int kRounds = 3;
  RefineOptions far, near;
  far.relative_tolerance = near.relative_tolerance = 1e-6;
  far.loss = {LossKind::kHuber, loss.scale};
  near.loss = loss;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<int> rows;
    const Matrix3Parameters f = FundamentalOf(*model);
    for (int i = 0; i < said.points.rows(); ++i)
      if (SampsonError(f, said.points.row(i).data()) <= kRefineReach * loss.scale) rows.push_back(i);
    const PointMatrix points = said.points(rows, Eigen::all);
    const Eigen::VectorXd weights = Eigen::VectorXd::Ones(points.rows());
    for (const RefineOptions& options : {far, near})
      if (RefineFocal(open, points, weights, options, kOpen, model).status != Status::kOk) return false;
  }
  return model->allFinite();
}

/// The part of the motion that is across the optical axes: of a motion straight ahead f is hardly seen, so that errors
/// that all matches share move it far.
double ShareAcross(const FocalParameters& model) {
  constexpr double kLeast = 0.1;
  const Svd3 svd = ComputeRotationSvd3(AsMatrix(model.head<9>()));
  const double along = std::max(std::abs(svd.u(2, 2)), std::abs(svd.v(2, 2)));
  return std::max(1.0 - along * along, kLeast);
}

/// What the matches say of the lengths that are open, where that is another thing.
std::optional<FocalConflict> ConflictOf(UnknownFocal open, const Said& said, const RobustLoss& loss) {
  // Of log f; of the deviation of what was said and found; of the log-likelihood. Chosen on pairs for tuning.
  constexpr double kLeastOff = 0.1, kDeviations = 2.0, kGain = 2.5;
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(said.points.rows());
  FocalParameters free = said.model, held = said.model;
  if (!Free(open, said, loss, &free)) return std::nullopt;
  FocalEvidence evidence(open, said.points, weights, loss, kOpen);
  if (!evidence.Select(free) || !evidence.Refine(&free) || evidence.PlaneShare() >= kOneSurface) return std::nullopt;
  held.tail<2>().setOnes();
  RefineOptions options;
  options.loss = loss;
  RefineWithFocal(open, said.points, weights, options, &held);
  const double gain = CostOf(held, said.points, loss) - CostOf(free, said.points, loss);
  if (!(gain > 2.0 * evidence.variance() * kGain)) return std::nullopt;

  const int focals = CountFocals(open);
  const Eigen::VectorXd off = free.tail(focals).array().log();
  Eigen::MatrixXd spread = kIntervalFactor * kIntervalFactor * evidence.Covariance(free);
  spread.diagonal().array() += std::pow(FloorOf(evidence.PlaneShare()) / ShareAcross(free), 2);
  const Eigen::MatrixXd both = spread + said.spread.bottomRightCorner(focals, focals);
  if (!(off.cwiseAbs().maxCoeff() > kLeastOff) || !(off.dot(both.ldlt().solve(off)) > kDeviations * kDeviations))
    return std::nullopt;
  FocalConflict conflict;
  for (int k = 0; k < 2; ++k) {
    const int image = said.swapped ? 1 - k : k, row = std::max(k + focals - 2, 0);
    const double spare = k == 0 && open == UnknownFocal::kSecond ? 0.0 : std::sqrt(spread(row, row));
    conflict.said_px[image] = said.px[k];
    conflict.found_px[image] = said.px[k] * free[9 + k];
    conflict.low_px[image] = conflict.found_px[image] * std::exp(-spare);
    conflict.high_px[image] = conflict.found_px[image] * std::exp(spare);
  }
  return conflict;
}

}  // namespace

std::optional<FocalConflict> FindFocalConflict(const NormalizedProblem& solved, const Estimate& estimate) {
  if (estimate.status != Status::kOk || !estimate.instances.empty() || solved.points().cols() != 4) return std::nullopt;
  const auto said = SaidOf(solved, estimate);
  if (!said || !said->points.allFinite()) return std::nullopt;
  const RobustLoss loss{LossKind::kTruncated, estimate.inlier_threshold / said->unit};
  for (const UnknownFocal open : said->open)
    if (const auto conflict = ConflictOf(open, *said, loss)) return conflict;
  return std::nullopt;
}

void TellFocalConflict(const NormalizedProblem& solved, Estimate* estimate) {
  estimate->focal_conflict = FindFocalConflict(solved, *estimate);
  if (!estimate->focal_conflict) return;
  estimate->pose_covariance.reset();
  if (!estimate->focal) return;
  for (int k = 0; k < 2; ++k) {
    // A calibrated image's stays.
    if (!(estimate->focal->prior_log_sigma[k] > 0.0)) continue;
    estimate->focal->observable[k] = false;
    estimate->focal->low_px[k] = std::min(estimate->focal->low_px[k], estimate->focal_conflict->low_px[k]);
    estimate->focal->high_px[k] = std::max(estimate->focal->high_px[k], estimate->focal_conflict->high_px[k]);
  }
}

}  // namespace diffsac
