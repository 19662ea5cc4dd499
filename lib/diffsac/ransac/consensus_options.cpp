#include "diffsac/ransac/consensus_options.h"

#include <string>

#include "diffsac/core/status.h"

namespace diffsac {

void ConsensusOptions::Check() const {
  const auto require = [](bool ok, const char* expected) {
    if (!ok) throw Error(std::string("consensus.") + expected);
  };
  require(max_iterations >= 1, "max_iterations: expected at least 1");
  require(min_iterations >= 0, "min_iterations: expected at least 0");
  require(confidence >= 0.0 && confidence < 1.0, "confidence: expected from 0 to below 1");
  require(residual_dof >= 0 && residual_dof <= 6, "residual_dof: expected from 0 to 6");
  require(score_threshold_factor > 0.0, "score_threshold_factor: expected a number above 0");
  require(refit_threshold_factor > 0.0, "refit_threshold_factor: expected a number above 0");
  require(sigma_factor > 0.0, "sigma_factor: expected a number above 0");
  require(inlier_prior > 0.0 && inlier_prior < 1.0, "inlier_prior: expected between 0 and 1");
  require(greatest_scale == 0.0 || least_scale < greatest_scale, "least_scale: expected below greatest_scale");
  require(refit_candidates >= 1, "refit_candidates: expected at least 1");
  require(graph_neighbors >= 1, "graph_neighbors: expected at least 1");
}

}  // namespace diffsac
