#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/geometry/focal.h"
#include "diffsac/geometry/points.h"
#include "diffsac/geometry/robust_loss.h"
#include "diffsac/ransac/stopping_rule.h"

namespace diffsac {

struct ConsensusResult {
  Status status = Status::kNoModel;
  ModelParameters model;
  std::vector<std::uint8_t> inliers;  ///< residual ≤ inlier_threshold under the returned model, exactly
  double inlier_threshold =
      std::numeric_limits<double>::quiet_NaN();  ///< ε, or less where options.threshold is adaptive
  /// Of a model of two minima: the other one, where it is as good.
  std::optional<ModelParameters> other = {};
  int other_inliers = 0;  ///< Of a rival (model_hooks.h): those that are no inliers of the model.
  /// Of a model with unknown focal lengths, where priors of them are given; in the units of the points.
  std::optional<FocalPosteriors> focal = {};
  double score = 0.0;  ///< of the returned model, by the score that chose it last
  /// σ of the inliers' residuals, one coordinate's (NoiseOfInliers in geometry/covariance.h); NaN without a model, or
  /// with γ inliers alone.
  double sigma = std::numeric_limits<double>::quiet_NaN();
  /// How the model was refined, in the unit of the points; nothing without a final refinement.
  std::optional<FitConditions> fit = {};
  int hypotheses = 0;  ///< models solved or fitted, all stages: each set, each least squares
  int unique_minimal_sets = 0;
  /// The first (up to kReportedSets) minimal sets that were drawn, for reports of what a sampler proposes.
  std::vector<std::vector<int>> first_sets;
  std::int64_t iterations = 0;            ///< minimal sets drawn
  StopReason stop = StopReason::kNotRun;  ///< why there were no more
};

}  // namespace diffsac
