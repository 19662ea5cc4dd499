#pragma once

#include "diffsac/core/enum_names.h"
#include "diffsac/core/range.h"
#include "diffsac/estimate/diffsac_model.h"
#include "diffsac/estimate/learned_estimator.h"
#include "diffsac/guidance/diffusion/reverse_sampler.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"

namespace diffsac {

/// How a set is taken from a copy's confidences c.
///   kMaximum        "maximum": top-γ
///   kProbabilistic  "probabilistic": γ drawn without replacement by softmax(c / temperature)
///   kGumbel         "gumbel": drawn in proportion to p^(1/temperature), p = (1 + c) / 2: top-γ of the log-
///                   probabilities with Gumbel noise, which keeps the copies apart where they agree. The inlier
///                   head's sets are always drawn in this proportion.
enum class SetSelection { kMaximum, kProbabilistic, kGumbel };
template <>
inline constexpr auto kEnumNames<SetSelection> = NamesOf<SetSelection>({{SetSelection::kMaximum, "maximum"},
                                                                        {SetSelection::kProbabilistic, "probabilistic"},
                                                                        {SetSelection::kGumbel, "gumbel"}});

/// How a trained network is used: the group `inference` of a training configuration (kept in the checkpoint), any key
/// of which a row of an experiment may override.
///
/// A row's sets are those of its κ copies, then `num_guided_samples`, then `num_uniform_samples`. With
/// `consensus.stopping: budget` the search takes exactly these. With `confidence` it ends as soon as it is confident,
/// and after them the last of the samplers goes on, up to consensus.max_iterations sets in all: the extra sampler, or
/// the inlier head, or the copies, whose turn comes again.
struct DiffsacOptions : LearnedOptions {
  /// κ: noise vectors of the reverse process, and minimal samples, for each problem; 0: no reverse process, the inlier
  /// head alone (num_guided_samples).
  int num_diffusion_samples = 20;
  ReverseSamplerOptions sampler;  ///< which reverse process, and how many network steps
  SetSelection selection = SetSelection::kMaximum;
  /// So many sets of the inlier head, after those of the copies: of a budget of 20, 10 and 10 are more diverse.
  int num_guided_samples = 0;
  /// By whose probabilities the inlier head's sets are drawn; kBoth also orders the points for PROSAC's extra sets.
  PriorSource draws_by = PriorSource::kNetwork;
  /// Of drawn sets; [first, last]: the copies go from the first to the last in equal ratios, so that some keep to the
  /// likeliest points and others look further, as PROSAC's growing sets do. The inlier head's sets go through ten such
  /// temperatures again and again.
  Range temperature = 0.25;
  /// So many sets more from another sampler, after the guided ones: uniform, or PROSAC, which samples uniformly on data
  /// without a quality.
  int num_uniform_samples = 0;
  MinimalSamplerKind extra_sampler = MinimalSamplerKind::kUniform;
  bool unique_sets = true;  ///< no minimal set of the copies is solved twice
  /// Where the copies have no new set, or go on, the predictions of earlier reverse steps follow, latest first.
  bool intermediate_sets = true;
  /// Decode only this many points of highest inlier probability; 0 decodes all. Needs the inlier head.
  int max_decoded_points = 0;

  /// Only so many points of highest prior (estimate/point_prior.h) go into the network; the others are weighed by
  /// that prior, and count in the score as ever. 0: all.
  int max_encoded_points = 0;
  NetworkEngine engine = NetworkEngine::kAuto;

  DiffsacOptions() { batch = 32; }
  /// The sets that the row asks for, which is the budget.
  int Sets() const { return num_diffusion_samples + num_guided_samples + num_uniform_samples; }
  /// Whether earlier predictions may stand behind the copies': only top-γ of unique sets runs out of new ones.
  bool UsesEarlierSteps() const {
    return num_diffusion_samples > 0 && intermediate_sets && unique_sets && selection == SetSelection::kMaximum;
  }
};

/// Throws Error for an option that the network cannot serve.
void CheckServes(const DiffsacOptions& options, const DiffsacModel& network);

}  // namespace diffsac
