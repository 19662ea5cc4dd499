#include "diffsac/estimate/estimation_priors.h"

#include <algorithm>
#include <cmath>

#include "diffsac/problem/coordinates.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

Eigen::Matrix3d GuessedCamera(const ImageSize& size) {
  return CentredCamera(kUsualFocal * std::max(size.width, size.height), size);
}

/// A focal length is as far from the prior's as (s₁ − s₂)/s₂ of a matrix is from 0, at one standard deviation: of two
/// lengths, of the one that is less certain.
CameraPrior FocalCameraPrior(const FocalPriors& priors, double strength) {
  const auto camera = [](const FocalPrior& prior) -> Eigen::Matrix3d {
    return Eigen::Vector3d(prior.focal, prior.focal, 1.0).asDiagonal();
  };
  const double sigma1 = priors[0].log_sigma, sigma2 = priors[1].log_sigma, most = std::max(sigma1, sigma2);
  return {camera(priors[0]), camera(priors[1]), strength / (most * most), {sigma1, sigma2}};
}

}  // namespace

EstimationPriors PriorsOfProblem(const NormalizedProblem& space, const ConsensusOptions& options) {
  EstimationPriors priors;
  priors.unit = space.unit();
  const Problem& problem = space.problem();
  if (problem.initial_model) priors.models.push_back(*problem.initial_model);
  if (options.camera_prior > 0.0 && problem.size1.known() && problem.size2.known())
    priors.cameras = CameraPrior{GuessedCamera(problem.size1), GuessedCamera(problem.size2), options.camera_prior};
  DispatchDescription(problem.task, [&]<class Description>() {
    if constexpr (requires { Description::PriorsOf(problem, 1.0); })
      priors.cameras = FocalCameraPrior(Description::PriorsOf(problem, options.focal_log_sigma), options.camera_prior);
  });
  if (options.keypoint_orientation_weight < 1.0 && problem.scale_rotation_changes.rows() == problem.points.rows()) {
    priors.turns.resize(problem.scale_rotation_changes.rows(), 2);
    priors.turns << problem.scale_rotation_changes.col(1).array().cos(),
        problem.scale_rotation_changes.col(1).array().sin();
  }
  priors.point_weights = PointWeights(problem);
  if (options.inlier_prior_power > 0.0) {
    priors.inlier_priors = priors.point_weights;
    if (priors.inlier_priors.size() == 0) priors.inlier_priors = space.match_probabilities();
  }
  return priors;
}

ConsensusOptions OptionsOfProblem(const NormalizedProblem& space, ConsensusOptions options) {
  options.least_scale *= space.noise().least;
  options.greatest_scale *= space.noise().greatest;
  // Surest matches crowd on what repeats least, often one plane: F needs the others as well (docs/drop_ins.md).
  if (space.problem().scored && space.problem().task == Task::kFundamental) options.inlier_prior_power *= 0.5;
  return options;
}

}  // namespace diffsac
