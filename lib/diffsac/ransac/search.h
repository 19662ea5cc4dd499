#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "diffsac/ransac/own_model.h"
#include "diffsac/ransac/sample_consensus_impl.h"
#include "diffsac/ransac/scores/number_of_false_alarms.h"

// A robust fit of any model: header-only in the model, so that a program's own is compiled with the program
// (docs/own_model.md). Models of the library, with networks and poses, are estimated by diffsac.h.
namespace diffsac::ransac {

/// Options of Search: an aggregate for designated initialisers, `{.max_residual = 2.0, .confidence = 0.9999, .seed =
/// 7}`.
struct Options {
  double max_residual = std::numeric_limits<double>::quiet_NaN();  ///< Required: largest residual of an inlier.
  /// The noise is estimated; this is the smallest threshold of inliers that is tried. Default: an eighth of
  /// max_residual.
  std::optional<double> min_residual = {};
  int max_iterations = 10000;  ///< Maximum number of minimal samples.
  int min_iterations = 100;    ///< Minimum number of minimal samples.
  /// Stops when a better model would have been sampled with this probability, in [0, 1).
  double confidence = 0.9999;
  int num_threads = 1;  ///< 0: one for each core. Results do not depend on it.
  /// A model to score in addition to the sampled ones.
  std::optional<ModelParameters> initial_model = {};
  std::uint64_t seed = 0;  ///< Seed of the random samples.
};

/// What is known of each point before the search; N values each, empty: nothing.
struct PointGuidance {
  /// Probability in [0, 1] that the point is an inlier. Points count with it in scores, and are drawn in proportion to
  /// it. A point of 0 never counts.
  Eigen::VectorXd inlier_probabilities = {};
  /// At least 0, in proportion to which points are drawn, in place of the probabilities.
  Eigen::VectorXd draw_weights = {};
};

/// Result of Search.
template <OwnModel M>
struct Estimate {
  Status status = Status::kNoModel;                      ///< Whether there is a model, or why not.
  typename M::Parameters model = M::Parameters::Zero();  ///< Zero unless ok().
  std::vector<std::uint8_t> inliers = {};  ///< N values: 1 for a residual of at most inlier_threshold, else 0.
  int num_inliers = 0;                     ///< Number of ones in `inliers`.
  double inlier_threshold = std::numeric_limits<double>::quiet_NaN();  ///< max_residual, or less: 2.5 sigma.
  /// Standard deviation of one coordinate of the inliers' residuals; NaN with γ inliers alone.
  double sigma = std::numeric_limits<double>::quiet_NaN();
  /// log10 of the number of models with as many inliers that points without structure would give (Log10Nfa in
  /// scores/number_of_false_alarms.h). Above 0 the model may be chance.
  double log10_nfa = std::numeric_limits<double>::infinity();
  double score = 0.0;                     ///< MSAC, marginalised over scales.
  int num_nonfinite = 0;                  ///< Rows with a value that is not finite: left out, never inliers.
  std::int64_t iterations = 0;            ///< Minimal samples drawn.
  StopReason stop = StopReason::kNotRun;  ///< Why there were no more.

  bool ok() const { return status == Status::kOk; }
};

namespace internal {

/// The arguments of one search, checked, and its policies that depend on no model.
struct Setting {
  /// Throws std::invalid_argument for what no data can be to blame for.
  Setting(const PointMatrix& all, int dimension, int set_size, int parameters, const Options& options,
          const PointGuidance& guidance);

  std::vector<int> rows;  ///< The finite ones.
  PointMatrix points;     ///< These rows.
  EstimationPriors priors;
  ConsensusOptions consensus;
  Rng rng;
  std::unique_ptr<MinimalSampler> sampler;
  std::optional<StoppingRule> stop;
};

/// Points without structure: of the plane or of space in the cube that the points fill (SpreadOf), of other dimensions
/// uniform in each coordinate of their box.
PointMatrix UnstructuredPoints(const PointMatrix& points, int count, Rng rng);

/// How likely a point that has nothing to do with the model is within a threshold of it, by a sample of such points.
template <class M>
double ChanceShare(const PointMatrix& points, const typename M::Parameters& model, double threshold, const Rng& rng) {
  constexpr int kSample = 4096;
  const PointMatrix sample = UnstructuredPoints(points, kSample, rng);
  int near = 1;
  for (int i = 0; i < kSample; ++i) near += M::Residual(model, sample.data() + i * sample.cols()) <= threshold ? 1 : 0;
  return static_cast<double>(near) / (kSample + 1);
}

}  // namespace internal

/// The model of these points, N × kDimension, and its inliers: minimal samples, scored by MSAC over noise scales up to
/// max_residual, the best of them optimised locally, until `confidence` is reached; then refits, and refinement where
/// the model has one. The same arguments and seed give the same result, bit for bit, for any number of threads.
///
/// Bad data gives a status: fewer than γ finite points, or none that determine a model. Throws std::invalid_argument
/// for a programmer's mistake: max_residual not given, another number of columns, guidance that is not N values.
template <OwnModel M>
Estimate<M> Search(const PointMatrix& points, const Options& options, const PointGuidance& guidance = {}) {
  using Model = Completed<M>;
  internal::Setting setting(points, M::kDimension, M::kMinimalSize, M::Parameters::SizeAtCompileTime, options,
                            guidance);
  Estimate<M> estimate;
  estimate.inliers.assign(points.rows(), 0);
  estimate.num_nonfinite = static_cast<int>(points.rows() - setting.points.rows());
  estimate.status = CheckPoints<Model>(setting.points);
  if (!estimate.ok()) return estimate;
  ConsensusOptions& consensus = setting.consensus;
  if constexpr (HasRefine<Model>) consensus.final_refinement = FinalRefinement::kMarginalised;
  if constexpr (Model::kFits) {
    consensus.local_optimization = LocalOptimization::kInnerSamples;
    consensus.refit = Refit::kIterated;
  }
  const ConsensusResult found =
      SearchUntil<Model>(*setting.stop, setting.points, options.max_residual, *setting.sampler, consensus, setting.rng,
                         setting.priors, options.num_threads);
  estimate.status = found.status;
  estimate.iterations = found.iterations;
  estimate.stop = found.stop;
  if (!estimate.ok()) return estimate;
  estimate.model = found.model;
  estimate.inlier_threshold = found.inlier_threshold;
  estimate.sigma = found.sigma;
  estimate.score = found.score;
  for (std::size_t i = 0; i < setting.rows.size(); ++i) {
    estimate.inliers[setting.rows[i]] = found.inliers[i];
    estimate.num_inliers += found.inliers[i];
  }
  const double share =
      internal::ChanceShare<M>(setting.points, estimate.model, found.inlier_threshold, setting.rng.Fork("chance"));
  estimate.log10_nfa = std::log10(Model::kMaxSolutions) +
                       Log10Nfa(static_cast<int>(setting.points.rows()), estimate.num_inliers, M::kMinimalSize, share);
  return estimate;
}

}  // namespace diffsac::ransac
