#pragma once

#include <string>

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/core/options.h"
#include "diffsac/diffusion/reverse_sampler.h"

namespace diffsac {

/// How a trained network is used: the group `inference` of a training configuration (kept in the checkpoint), any key of
/// which a row of an experiment may override.
struct DiffsacOptions {
  int copies = 20;                       ///< κ: noise vectors, and minimal sets, for each problem
  SamplerOptions sampler;                ///< which reverse process, and how many network steps
  /// "maximum" (top-γ) | "probabilistic" (γ drawn without replacement by softmax(confidence / temperature)) |
  /// "gumbel" (drawn in proportion to p^(1/temperature), p = (1 + confidence) / 2: top-γ of the log-probabilities with
  /// Gumbel noise, which keeps the copies apart where they agree).
  std::string selection = "maximum";
  /// Of "probabilistic" and "gumbel"; [first, last]: the copies go from the first to the last in equal ratios, so that
  /// some keep to the likeliest points and others look further, as PROSAC's growing sets do.
  Range temperature = 0.25;
  /// "diffusion" | "inlier_head": sets come from the inlier head's probabilities, the same for all copies, without any
  /// reverse step: what independent sampling from learned weights reaches.
  std::string guide = "diffusion";
  /// So many sets more from the inlier head, after those of the copies: of a budget of 20, 10 and 10 are more diverse.
  int head_sets = 0;
  /// So many sets more from another source ("uniform" | "prosac"), after the guided ones.
  int extra_sets = 0;
  std::string extra_source = "uniform";
  /// Points in a minimal set of a fundamental matrix, 7 or 8: as the labels of the training had.
  int fundamental_points = 7;
  bool unique_sets = true;               ///< no minimal set is solved twice
  /// Fill the places of repeated sets from the predictions of earlier reverse steps, latest first.
  bool intermediate_sets = true;
  /// Score the hypotheses that the features were made from as well (they are paid for and counted).
  bool feature_hypotheses = false;
  /// Add one weighted least-squares hypothesis with the network's inlier probabilities as weights.
  bool learned_refit = false;
  /// Decode only this many points of highest inlier probability; 0 decodes all. Needs the inlier head.
  int max_decoded_points = 0;
  /// Minimal sets that the preference features are drawn from, all counted in the budget; 0: as in training. More find a
  /// good hypothesis at high outlier ratios; the network still sees the best `preference_kept` of them.
  int preference_draws = 0;
  int batch = 32;                        ///< problems a network call
  ConsensusOptions consensus;
  void Bind(OptionsBinder& b);
};

}  // namespace diffsac
