#include "diffsac/consensus/sample_consensus.h"

#include <cmath>

#include "diffsac/consensus/best_hypotheses.h"
#include "diffsac/consensus/local_optimization.h"
#include "diffsac/consensus/mixture.h"
#include "diffsac/consensus/scorer.h"

namespace diffsac {
namespace {

enum class Refit { kNone, kInliers, kIterated, kMixture };

Refit RefitFromString(const std::string& name) {
  if (name == "none") return Refit::kNone;
  if (name == "inliers") return Refit::kInliers;
  if (name == "iterated") return Refit::kIterated;
  if (name == "em") return Refit::kMixture;
  throw Error("unknown refit '" + name + "': expected none, inliers, iterated or em");
}

bool LocalOptimizationFromString(const std::string& name) {
  if (name == "none") return false;
  if (name == "lo_ransac") return true;
  throw Error("unknown local_optimization '" + name + "': expected none or lo_ransac");
}

/// One run over one point set: what is fixed, and the hypotheses gathered so far.
template <MinimalModel Model>
class Run {
 public:
  using Parameters = typename Model::Parameters;

  Run(const PointMatrix& points, double threshold, const ConsensusOptions& options, Rng rng)
      : options_(options),
        threshold_(threshold),
        score_threshold_(options.score_threshold_factor * threshold),
        mixture_(MakeMixture(points, threshold, options.sigma_factor * threshold)),
        optimize_locally_(LocalOptimizationFromString(options.local_optimization)),
        refit_(RefitFromString(options.refit)),
        final_kind_(ScoreKindFromString(options.final_score)),
        rng_(rng),
        scorer_(points),
        score_(MakeScore(ScoreKindFromString(options.score))),
        final_(MakeScore(final_kind_)),
        best_(points, score_threshold_, std::max(1, options.refit_candidates)) {}

  void ConsiderSets(const std::vector<int>& sets) {
    constexpr int kSize = Model::kMinimalSize;
    Parameters models[Model::kMaxSolutions];
    for (std::size_t start = 0; start + kSize <= sets.size(); start += kSize) {
      const int* set = sets.data() + start;
      const bool valid = std::all_of(set, set + kSize, [&](int i) { return i >= 0 && i < scorer_.size(); });
      const int solutions = valid ? Model::SolveMinimal(scorer_.points(), set, models) : 0;
      hypotheses_ += std::max(1, solutions);
      for (int i = 0; i < solutions; ++i) Consider(models[i]);
    }
  }

  void ConsiderHints(const ConsensusHints& hints) {
    for (const ModelParameters& hint : hints.models)
      if (hint.size() == Parameters::SizeAtCompileTime && hint.allFinite()) Consider(hint);
    if (hints.fit_weights.size() == 0) return;
    Parameters model;
    ++hypotheses_;
    if (Model::Fit(scorer_.points(), hints.fit_weights, &model)) Consider(model);
  }

  void Finish(ConsensusResult* result) {
    for (const auto& entry : best_.entries()) {
      const Parameters model = Refitted(entry.model);
      const double score = FinalScore(model);
      if (result->model.size() > 0 && !(score > result->score)) continue;
      result->model = model;
      result->score = score;
    }
    if (result->model.size() > 0 && refit_ == Refit::kMixture && options_.sigma_prior > 0.0) EstimateSigmaToo(result);
    result->hypotheses = hypotheses_;
    if (result->model.size() == 0 || CountInliers(result->model) < Model::kMinimalSize) {
      result->model.resize(0);
      result->score = 0.0;
      return;
    }
    result->inliers = InlierMask<Model>(scorer_.points(), result->model, threshold_);
    result->status = Status::kOk;
  }

 private:
  Score MakeScore(ScoreKind kind) const {
    return Score(kind, score_threshold_, mixture_.sigma, mixture_.Odds(options_.inlier_prior));
  }

  void Consider(const Parameters& model) {
    const double score = scorer_(model, score_, best_.bar());
    const bool is_best = score > best_.best();
    best_.Offer(model, score);
    if (!is_best || !optimize_locally_) return;
    const Rng rng = rng_.Fork("local_optimization", local_runs_++);
    const ScoredModel<Model> optimized = OptimizeLocally<Model>(
        scorer_, score_, score_threshold_, options_.local_samples, {model, score}, rng, &hypotheses_);
    best_.Offer(optimized.model, optimized.score);
  }

  int CountInliers(const Parameters& model) const {
    return static_cast<int>((scorer_.Residuals(model).array() <= threshold_).count());
  }

  double InlierShare(const Parameters& model) const { return static_cast<double>(CountInliers(model)) / scorer_.size(); }

  double FinalScore(const Parameters& model) const {
    if (final_kind_ == ScoreKind::kGaussianUniform) return MixtureScore(mixture_, scorer_.Residuals(model));
    return scorer_(model, final_);
  }

  Parameters Refitted(const Parameters& start) {
    Parameters model = start;
    const double threshold = options_.refit_threshold_factor * threshold_;
    if (refit_ == Refit::kInliers) {
      ++hypotheses_;
      FitInliers(scorer_, threshold, &model);
    } else if (refit_ == Refit::kIterated) {
      model = Iterated(start, threshold);
    } else if (refit_ == Refit::kMixture) {
      hypotheses_ += MixtureRefit<Model>(scorer_.points(), mixture_, InlierShare(start), &model);
    }
    return CountInliers(model) < Model::kMinimalSize ? start : model;
  }

  /// Once, for the model that won with σ assumed: candidates that each chose their own σ would not compare as well
  /// (docs/experiments.md).
  void EstimateSigmaToo(ConsensusResult* result) {
    Parameters model = result->model;
    hypotheses_ += MixtureRefit<Model>(scorer_.points(), mixture_, InlierShare(model), &model,
                                       options_.sigma_prior);
    if (CountInliers(model) < Model::kMinimalSize) return;
    result->model = model;
    result->score = FinalScore(model);
  }

  Parameters Iterated(const Parameters& start, double threshold) {
    Parameters model = start;
    double score = FinalScore(start);
    for (int round = 0; round < options_.refit_rounds; ++round) {
      Parameters next = model;
      ++hypotheses_;
      if (!FitInliers(scorer_, threshold, &next)) break;
      const double next_score = FinalScore(next);
      if (!(next_score >= score)) break;
      const bool settled = next == model;
      model = next;
      score = next_score;
      if (settled) break;
    }
    return model;
  }

  const ConsensusOptions& options_;
  double threshold_;
  double score_threshold_;
  Mixture mixture_;
  bool optimize_locally_;
  Refit refit_;
  ScoreKind final_kind_;
  Rng rng_;
  Scorer<Model> scorer_;
  Score score_;
  Score final_;
  BestHypotheses<Model> best_;
  int hypotheses_ = 0;
  std::uint64_t local_runs_ = 0;
};

}  // namespace

template <MinimalModel Model>
Status CheckPoints(const PointMatrix& points) {
  if (points.rows() < Model::kMinimalSize) return Status::kTooFewPoints;
  if (points.cols() != Model::kDimension || !points.allFinite()) return Status::kDegenerate;
  if constexpr (requires { Model::Determined(points); }) {
    if (!Model::Determined(points)) return Status::kDegenerate;
  }
  return Status::kOk;
}

template <MinimalModel Model>
ConsensusResult SampleConsensus(const PointMatrix& points, double inlier_threshold,
                                const std::vector<int>& minimal_sets, const ConsensusOptions& options, Rng rng,
                                const ConsensusHints& hints) {
  ConsensusResult result;
  result.status = CheckPoints<Model>(points);
  if (result.status != Status::kOk) return result;
  result.status = Status::kNoModel;
  if (!(inlier_threshold > 0.0) || !std::isfinite(inlier_threshold)) return result;
  result.unique_minimal_sets = CountUniqueSets(minimal_sets, Model::kMinimalSize);
  Run<Model> run(points, inlier_threshold, options, rng);
  run.ConsiderSets(minimal_sets);
  run.ConsiderHints(hints);
  run.Finish(&result);
  return result;
}

template ConsensusResult SampleConsensus<Line>(const PointMatrix&, double, const std::vector<int>&,
                                               const ConsensusOptions&, Rng, const ConsensusHints&);
template ConsensusResult SampleConsensus<Plane>(const PointMatrix&, double, const std::vector<int>&,
                                                const ConsensusOptions&, Rng, const ConsensusHints&);
template Status CheckPoints<Line>(const PointMatrix&);
template Status CheckPoints<Plane>(const PointMatrix&);

}  // namespace diffsac
