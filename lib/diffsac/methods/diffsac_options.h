#pragma once

#include <cstdint>
#include <string>

#include "diffsac/core/options.h"
#include "diffsac/diffusion/reverse_sampler.h"
#include "diffsac/methods/diffsac_network.h"
#include "diffsac/methods/learned_method.h"

namespace diffsac {

/// How a trained network is used: the group `inference` of a training configuration (kept in the checkpoint), any key of
/// which a row of an experiment may override.
///
/// A row's sets are those of its κ copies, then `head_sets`, then `extra_sets`. With `consensus.stopping: budget` the
/// search takes exactly these. With `confidence` it ends as soon as it is confident, and after them the last of the
/// sources goes on, up to consensus.max_iterations sets in all: the extra source, or the inlier head, or the copies,
/// whose turn comes again.
struct DiffsacOptions : LearnedOptions {
  int copies = 20;                       ///< κ: noise vectors, and minimal sets, for each problem
  SamplerOptions sampler;                ///< which reverse process, and how many network steps
  /// "maximum" (top-γ) | "probabilistic" (γ drawn without replacement by softmax(confidence / temperature)) |
  /// "gumbel" (drawn in proportion to p^(1/temperature), p = (1 + confidence) / 2: top-γ of the log-probabilities with
  /// Gumbel noise, which keeps the copies apart where they agree). The inlier head's sets are always drawn as by
  /// "gumbel".
  std::string selection = "maximum";
  /// Of drawn sets; [first, last]: the copies go from the first to the last in equal ratios, so that some keep to the
  /// likeliest points and others look further, as PROSAC's growing sets do. The inlier head's sets go through ten such
  /// temperatures again and again.
  Range temperature = 0.25;
  /// "diffusion" | "inlier_head": sets, `copies` of them, come from the inlier head's probabilities, without any reverse
  /// step: what independent sampling from learned weights reaches.
  std::string guide = "diffusion";
  /// So many sets more from the inlier head, after those of the copies: of a budget of 20, 10 and 10 are more diverse.
  int head_sets = 0;
  /// So many sets more from another source ("uniform" | "prosac"), after the guided ones. PROSAC on data without a
  /// quality samples uniformly.
  int extra_sets = 0;
  std::string extra_source = "uniform";
  bool unique_sets = true;               ///< no minimal set of the copies is solved twice
  /// Where the copies have no new set, or go on, the predictions of earlier reverse steps follow, latest first.
  bool intermediate_sets = true;
  /// Decode only this many points of highest inlier probability; 0 decodes all. Needs the inlier head.
  int max_decoded_points = 0;

  DiffsacOptions() { batch = 32; }
  void Bind(OptionsBinder& b);
  /// The sets that the row asks for, which is the budget.
  int Sets() const { return copies + (guide == "diffusion" ? head_sets : 0) + extra_sets; }
  /// Whether earlier predictions may stand behind the copies': only top-γ of unique sets runs out of new ones.
  bool UsesEarlierSteps() const { return intermediate_sets && unique_sets && selection == "maximum"; }
};

/// Throws Error for an option that the network cannot serve.
void CheckOptions(const DiffsacOptions& options, const DiffsacNetwork& network);

/// Throws Error with its line for a key that the row itself writes and that changes nothing there. options: the row's,
/// those of its checkpoint below them.
void CheckRow(const Config& row, const DiffsacOptions& options, const DiffsacNetwork& network);

}  // namespace diffsac
