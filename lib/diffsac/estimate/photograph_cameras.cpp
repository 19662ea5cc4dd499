#include "diffsac/estimate/photograph_cameras.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/estimate/presets.h"
#include "diffsac/geometry/covariance.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/geometry/robust_loss_sums.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/samplers/weighted_sampler.h"

namespace diffsac {
namespace {

/// Chosen on the tuning and training scenes (docs/two_view.md): minimal sets of one unknown focal length, among how
/// many matches; and by how much, in variances of the matches' noise, the loss may rise before a camera is against
/// them. Of crops the matches say so with fewer.
constexpr int kDraws = 10;
constexpr int kMostSearched = 300;
constexpr double kMostRise = 20.0;

/// Where the matches allow one camera its focal length is surer than MarginaliseFocal says: of the intervals of log f,
/// this share holds the truth in 68 % of the tuning and training pairs.
FocalPosteriors Narrowed(FocalPosteriors posteriors) {
  constexpr double kShare = 0.7;
  for (FocalPosterior& posterior : posteriors)
    for (double* end : {&posterior.low, &posterior.high})
      *end = posterior.focal * std::pow(*end / posterior.focal, kShare);
  return posteriors;
}

/// Rows whose residual is within a reach, evenly thinned to `most` or a few more.
std::vector<int> RowsWithin(double reach, const Eigen::VectorXd& residuals, int most) {
  const int step = std::max(1, static_cast<int>((residuals.array() <= reach).count()) / most);
  std::vector<int> rows;
  int seen = 0;
  for (int i = 0; i < residuals.size(); ++i)
    if (residuals[i] <= reach && seen++ % step == 0) rows.push_back(i);
  return rows;
}

/// Searched among matches that F explains: its own landscape has other optima, and of matches on a plane it is any of
/// many. The model is the median of the posterior of the focal length.
ConsensusResult SearchedCamera(const PointMatrix& points, const Eigen::VectorXd& weights, double unit, const Rng& rng) {
  ConsensusOptions options = RecommendedClassical(Task::kSharedFocal).consensus;
  options.max_iterations = options.min_iterations = kDraws;
  const double sigma = options.focal_log_sigma;
  EstimationPriors priors;
  priors.unit = unit;
  priors.inlier_priors = weights;
  priors.cameras = CameraPrior{
      Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity(), options.camera_prior / (sigma * sigma), {sigma, sigma}};
  WeightedSampler sampler({weights.data(), static_cast<std::size_t>(weights.size())}, SharedFocal::kMinimalSize, rng);
  return SampleConsensus<SharedFocal>(points, 1.0 / unit, sampler, options, rng, priors);
}

}  // namespace

void PutCameraBehind(const NormalizedProblem& space, const Rng& rng, ConsensusResult* found) {
  const Problem& problem = space.problem();
  if (problem.task != Task::kFundamental || found->status != Status::kOk || !found->fit) return;
  const auto frame = FocalSpaceOf(UnknownFocal::kBoth, problem);
  if (!frame || !problem.size1.known() || problem.size1 != problem.size2) return;
  double unit = 1.0;
  const PointMatrix points = NormalizeFocal(UnknownFocal::kBoth, problem, &unit);
  Eigen::VectorXd weights = found->fit->weights;
  if (weights.size() == 0) weights.setOnes(points.rows());
  const RobustLoss loss{found->fit->loss.kind, found->fit->loss.scale / unit, found->fit->loss.least / unit};
  const Eigen::Matrix3d own = frame->second.inverse().transpose() * ModelMatrix(found->model) * frame->first.inverse();
  const Eigen::VectorXd before = RowResiduals<Fundamental>(points, AsParameters(own / own.norm()));

  const std::vector<int> nearest = RowsWithin(loss.scale, before, kMostSearched);
  const ConsensusResult camera =
      SearchedCamera(points(nearest, Eigen::all), weights(nearest), unit, rng.Fork("cameras"));
  found->hypotheses += camera.hypotheses;
  if (camera.status != Status::kOk) return;
  const Matrix3Parameters f = FundamentalOf(FocalParameters(camera.model));
  const std::vector<int> near = RowsWithin(kRefineReach * loss.scale, before, static_cast<int>(points.rows()));
  const Eigen::VectorXd of_near = weights(near), were = before(near),
                        are = RowResiduals<Fundamental>(points(near, Eigen::all), f);
  const int count = static_cast<int>(near.size());
  const double variance = ResidualVariance(loss, were.data(), of_near.data(), count, FreeParameters<Fundamental>());
  const double rise =
      SumLoss(loss, are.data(), of_near.data(), count) - SumLoss(loss, were.data(), of_near.data(), count);
  if (!(rise <= kMostRise * variance)) return;

  const Eigen::Matrix3d in_pixels = frame->second.transpose() * AsMatrix(f) * frame->first;
  const Matrix3Parameters model = AsParameters(in_pixels / in_pixels.norm());
  const Eigen::VectorXd after = RowResiduals<Fundamental>(space.points(), model);
  const double noise = NoiseOfInliers(after, 1, FreeParameters<Fundamental>(), found->fit->threshold);
  if (!std::isfinite(noise)) return;
  found->model = model;
  found->sigma = noise;
  if (!problem.cameras && camera.focal) found->focal = Narrowed(*camera.focal);
  for (Eigen::Index i = 0; i < after.size(); ++i) found->inliers[i] = after[i] <= found->inlier_threshold;
}

}  // namespace diffsac
