#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>
#include <utility>

#include "diffsac/core/embedded_models.h"
#include "diffsac/core/lru_cache.h"
#include "diffsac/diffsac.h"
#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/presets.h"
#include "diffsac/estimate/problems_of_inputs.h"
#include "diffsac/estimate/require.h"
#include "diffsac/geometry/calibration.h"
#include "diffsac/problem/coordinates.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/problem/within_size.h"

namespace diffsac {
namespace {

/// Horizons of two focal lengths are the same where they differ by less than this share of the image's width at its
/// sides.
constexpr double kSameHorizon = 0.01;

/// Of log f before anything is seen.
const double kFocalLogSigma = ConsensusOptions().focal_log_sigma;

/// Kept by what it is made of.
std::shared_ptr<const ClassicalEstimator> SearchOf(const VanishingPointOptions& options) {
  using Key = std::tuple<Guidance, bool, double, std::optional<int>, std::string>;
  static LruCache<ClassicalEstimator, Key> kept(32);
  return kept.Get(
      {options.guidance, options.K.has_value(), options.least_value, options.max_iterations, options.models_folder},
      [&] {
        std::string chooser;
        if (options.guidance == Guidance::kNetwork)
          chooser = ModelPlace(ChooserFile(options.K.has_value()), options.models_folder);
        ClassicalOptions search = VanishingPoints(chooser);
        search.instances.least_value = options.least_value;
        Apply(SharedOptions(options), &search);
        return std::make_shared<const ClassicalEstimator>(search);
      });
}

Problem ProblemOf(const SegmentsView& segments, const VanishingPointOptions& options) {
  Problem problem;
  problem.task = Task::kVanishingPoint;
  problem.points = segments.matrix();
  problem.inlier_threshold = options.max_residual_deg;
  problem.size1 = options.size;
  if (options.K) problem.cameras = CameraPair{*options.K, *options.K};
  return problem;
}

std::vector<double> WeightsOf(const VanishingPointsEstimate& estimate) {
  return estimate.values.empty() ? std::vector<double>(estimate.points.size(), 1.0) : estimate.values;
}

/// The horizon of a focal length that is unknown, where it is about the same for short and long ones.
std::optional<Horizon> HorizonOfAnyFocal(const VanishingPointsEstimate& estimate, const ImageSize& size) {
  const double middle = kMedianFocal * std::max(size.width, size.height), step = std::exp(kFocalLogSigma);
  const auto at = [&](double focal) {
    return HorizonOf(estimate.points, WeightsOf(estimate), CentredCamera(focal, size));
  };
  const auto likely = at(middle), near = at(middle / step), far = at(middle * step);
  if (!likely || !near || !far) return std::nullopt;
  for (const double x : {0.0, double(size.width)})
    if (!(std::abs(near->RowAt(x) - far->RowAt(x)) < kSameHorizon * size.width)) return std::nullopt;
  return likely;
}

void FindCamera(const ImageSize& size, VanishingPointsEstimate* estimate) {
  const Eigen::Vector2d middle = CentredCamera(1.0, size).topRightCorner<2, 1>();
  const FocalPrior prior{kMedianFocal * std::max(size.width, size.height), kFocalLogSigma};
  estimate->focal = FocalOfVanishingPoints(estimate->points, WeightsOf(*estimate), middle, prior);
  if (estimate->focal) estimate->K = CentredCamera(estimate->focal->focal_px, size);
}

void Check(const VanishingPointOptions& options) {
  Require(options.max_residual_deg > 0.0 && options.max_residual_deg <= 90.0, "max_residual_deg",
          "degrees, above 0 and at most 90");
  Require(options.least_value >= 0.0 && options.least_value <= 1.0, "least_value", "from 0 to 1");
  Require(options.guidance != Guidance::kDiffusion, "guidance",
          "none or network: diffusion has no network for vanishing points");
  Require(options.K || options.size.known(), "size", "the image's size, or K");
}

}  // namespace

VanishingPointsEstimate EstimateVanishingPoints(const SegmentsView& segments, const VanishingPointOptions& given) {
  Check(given);
  VanishingPointOptions options = given;
  if (options.K) options.K = CheckedCalibration(*options.K, "K");
  RequireWithin(options.size, segments.matrix().leftCols(2), "size");
  RequireWithin(options.size, segments.matrix().rightCols(2), "size");
  const Problem problem = ProblemOf(segments, options);
  Estimate found = SearchOf(options)->Run(problem, options.seed);
  VanishingPointsEstimate estimate;
  estimate.status = found.status;
  estimate.stats = found.stats;
  estimate.num_nonfinite = found.num_nonfinite;
  estimate.num_duplicates = found.num_duplicates;
  estimate.assignment = std::move(found.assignment);
  estimate.assignment.resize(found.inliers.size());
  estimate.K = options.K;
  if (!estimate.ok()) return estimate;
  for (const ModelParameters& model : found.instances)
    estimate.points.push_back(VanishingPointTask::PixelPoint(model, problem));
  estimate.values = std::move(found.instance_values);
  if (!estimate.K) FindCamera(options.size, &estimate);
  if (!estimate.K) {
    estimate.horizon = HorizonOfAnyFocal(estimate, options.size);
    return estimate;
  }
  for (const Eigen::Vector3d& point : estimate.points) estimate.directions.push_back(DirectionOf(point, *estimate.K));
  estimate.horizon = HorizonOf(estimate.points, WeightsOf(estimate), *estimate.K);
  return estimate;
}

}  // namespace diffsac
