#include "diffsac/estimate/photograph_cameras.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "diffsac/estimate/presets.h"
#include "diffsac/geometry/calibration.h"
#include "diffsac/geometry/covariance.h"
#include "diffsac/geometry/photographs.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/geometry/robust_loss_sums.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/samplers/weighted_sampler.h"

namespace diffsac {
namespace {

/// Chosen on the tuning and training scenes (docs/two_view.md): minimal sets of unknown focal lengths; the share of an
/// independent match's evidence that each has, of photographs, whose errors go together; and by how much, in variances
/// of the matches' noise, the cost may rise before cameras are against the matches.
constexpr int kDraws = 10;
/// Enough matches for a start.
constexpr Eigen::Index kMostSearched = 300;
constexpr double kIndependentShare = 0.1, kMostRise = 20.0;
/// The standard deviation of log f of photographs.
constexpr double kLogSigma = 0.43;

/// Cameras whose focal lengths are searched among matches that F explains: its own landscape has other optima, and of
/// matches on a plane it is any of many.
template <UnknownFocal kUnknown>
std::optional<FocalParameters> SearchedCameras(const NearMatches& matches, double unit, const Rng& rng, int* fits) {
  using Model = FocalModel<kUnknown>;
  ConsensusOptions options =
      RecommendedClassical(kUnknown == UnknownFocal::kBoth ? Task::kSharedFocal : Task::kTwoFocals).consensus;
  options.max_iterations = options.min_iterations = kDraws;
  EstimationPriors priors;
  priors.unit = unit;
  priors.inlier_priors = matches.weights;
  // The posterior's median, of one length; of two it would take longer than the search for F.
  if constexpr (kUnknown == UnknownFocal::kBoth)
    priors.cameras = CameraPrior{Eigen::Matrix3d::Identity(),
                                 Eigen::Matrix3d::Identity(),
                                 options.camera_prior / (kLogSigma * kLogSigma),
                                 {kLogSigma, kLogSigma}};
  const PointMatrix points = matches.points;
  WeightedSampler sampler({matches.weights.data(), static_cast<std::size_t>(matches.Count())}, Model::kMinimalSize,
                          rng);
  const ConsensusResult found = SampleConsensus<Model>(points, 1.0 / unit, sampler, options, rng, priors);
  *fits += found.hypotheses;
  if (found.status != Status::kOk) return std::nullopt;
  return FocalParameters(found.model);
}

/// Cameras that F makes nearly, of the focal lengths that a coarse grid finds likeliest.
FocalParameters CamerasOf(const Matrix3Parameters& f, bool one_size) {
  constexpr double kReach = 1.2, kStep = 0.2, kMismatch = 0.02;  // Of log f; of (s₁ − s₂)/(s₁ + s₂).
  const auto camera = [](double log_focal) -> Eigen::Matrix3d {
    return Eigen::Vector3d(std::exp(log_focal), std::exp(log_focal), 1.0).asDiagonal();
  };
  double least = std::numeric_limits<double>::infinity(), log1 = 0.0, log2 = 0.0;
  for (double a = -kReach; a < kReach + 0.5 * kStep; a += kStep)
    for (double b = one_size ? a : -kReach; b < (one_size ? a : kReach) + 0.5 * kStep; b += kStep) {
      const double mismatch = Fundamental::CameraMismatch(f, camera(a), camera(b));
      const double off = mismatch / (2.0 + mismatch) / kMismatch;
      const double value = off * off + (a * a + b * b) / (kLogSigma * kLogSigma);
      if (!(value < least)) continue;
      least = value;
      log1 = a;
      log2 = b;
    }
  const Eigen::Matrix3d e = EssentialFromFundamental(AsMatrix(f), camera(log1), camera(log2));
  return AsFocalParameters(AsParameters(ClosestEssential(e)), std::exp(log1), std::exp(log2));
}

/// The rows of residuals within a reach, evenly thinned to `most` or a few more.
NearMatches NearestOf(const NearMatches& matches, const Eigen::VectorXd& residuals, double reach,
                      Eigen::Index most = std::numeric_limits<Eigen::Index>::max()) {
  const Eigen::Index within = (residuals.array() <= reach).count(), step = std::max<Eigen::Index>(1, within / most);
  std::vector<Eigen::Index> near;
  Eigen::Index seen = 0;
  for (Eigen::Index i = 0; i < residuals.size(); ++i)
    if (residuals[i] <= reach && seen++ % step == 0) near.push_back(i);
  return {matches.points(near, Eigen::all), matches.weights(near), matches.loss, matches.variance};
}

/// F of the likeliest cameras.
Matrix3Parameters RefinedFrom(const std::vector<FocalParameters>& starts, const NearMatches& matches, bool one_size) {
  const FocalPrior prior{kUsualFocal / kMedianFocal, kLogSigma};
  double least = std::numeric_limits<double>::infinity();
  PhotographPair best{starts.front()};
  for (const FocalParameters& start : starts) {
    PhotographPair pair{start};
    const double cost = RefinePhotographs(matches, {{prior, prior}, one_size}, &pair);
    if (!(cost < least)) continue;
    least = cost;
    best = pair;
  }
  return FundamentalOf(best);
}

double CostOf(const NearMatches& matches, const Matrix3Parameters& f) {
  Eigen::VectorXd distances(matches.Count());
  SampsonDistances(f.data(), matches.Columns().data(), 0, matches.Count(), distances.data());
  return SumLoss(matches.loss, distances.data(), matches.weights.data(), matches.Count());
}

}  // namespace

void PutCamerasBehind(const NormalizedProblem& space, const Rng& rng, ConsensusResult* found) {
  const Problem& problem = space.problem();
  if (problem.task != Task::kFundamental || found->status != Status::kOk || !found->fit) return;
  const auto frame = FocalSpaceOf(UnknownFocal::kEach, problem);
  if (!frame || !problem.size1.known() || !problem.size2.known()) return;
  double unit = 1.0;
  NearMatches matches{NormalizeFocal(UnknownFocal::kEach, problem, &unit), found->fit->weights, {}, 0.0};
  if (matches.weights.size() == 0) matches.weights.setOnes(matches.points.rows());
  const RobustLoss& loss = found->fit->loss;
  matches.loss = {loss.kind, loss.scale / unit, loss.least / unit};
  const Eigen::Matrix3d own = frame->second.inverse().transpose() * ModelMatrix(found->model) * frame->first.inverse();
  const Matrix3Parameters f = AsParameters(own / own.norm());
  Eigen::VectorXd residuals = RowResiduals<Fundamental>(PointMatrix(matches.points), f);
  matches = NearestOf(matches, residuals, kRefineReach * matches.loss.scale);
  residuals = RowResiduals<Fundamental>(PointMatrix(matches.points), f);
  const double variance = ResidualVariance(matches.loss, residuals.data(), matches.weights.data(), matches.Count(),
                                           FreeParameters<Fundamental>());
  if (!(variance > 0.0) || !std::isfinite(variance)) return;
  matches.variance = variance / kIndependentShare;

  const bool one_size = problem.size1 == problem.size2;
  const NearMatches nearest = NearestOf(matches, residuals, matches.loss.scale, kMostSearched);
  const Rng own_rng = rng.Fork("cameras");
  const auto searched = one_size ? SearchedCameras<UnknownFocal::kBoth>(nearest, unit, own_rng, &found->hypotheses)
                                 : SearchedCameras<UnknownFocal::kEach>(nearest, unit, own_rng, &found->hypotheses);
  std::vector<FocalParameters> starts{CamerasOf(f, one_size)};
  if (searched) starts.push_back(*searched);
  const double before = CostOf(matches, f);
  const auto fits = [&](const Matrix3Parameters& other) {
    return other.allFinite() && CostOf(matches, other) - before <= kMostRise * variance;
  };
  // One length and principal points in the middle, if the matches allow it.
  Matrix3Parameters refined = searched && one_size ? FundamentalOf(*searched) : f;
  if (refined == f || !fits(refined)) {
    refined = RefinedFrom(starts, matches, one_size);
    ++found->hypotheses;
    if (!fits(refined)) return;
  }
  const Eigen::Matrix3d in_pixels = frame->second.transpose() * AsMatrix(refined) * frame->first;
  const Matrix3Parameters model = AsParameters(in_pixels / in_pixels.norm());
  const Eigen::VectorXd after = RowResiduals<Fundamental>(space.points(), model);
  const double noise = NoiseOfInliers(after, 1, FreeParameters<Fundamental>(), found->fit->threshold);
  if (!std::isfinite(noise)) return;
  found->model = model;
  found->sigma = noise;
  for (Eigen::Index i = 0; i < after.size(); ++i) found->inliers[i] = after[i] <= found->inlier_threshold;
}

}  // namespace diffsac
