#include <string>
#include <utility>

#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/estimate/task_dispatch.h"
#include "lab/baselines/dgsac.h"
#include "lab/config/estimator_registry.h"
#include "lab/options/options.h"

namespace diffsac {

/// kDensity: the model is DGSAC's own, found without the problem's inlier threshold | kConsensus: it then passes the
/// local optimisation and the refits of `consensus`, which use the threshold, as the other rows' models do.
enum class DgsacFinish { kDensity, kConsensus };
template <>
inline constexpr auto kEnumNames<DgsacFinish> = NamesOf<DgsacFinish>({{DgsacFinish::kDensity, "density"},
                                                                      {DgsacFinish::kConsensus, "consensus"}});

namespace {

/// Options of the row `dgsac`.
struct DgsacEstimatorOptions {
  DgsacOptions search;
  DgsacFinish finish = DgsacFinish::kDensity;
  ConsensusOptions consensus;
  void Bind(OptionsBinder& b) {
    search.Bind(b);
    b.Field("finish", finish)
        .Help("density: DGSAC's own model, without a threshold; consensus: it passes local optimisation and refits");
    b.Field("consensus", consensus)
        .OnlyIf(finish == DgsacFinish::kConsensus, "finish: consensus")
        .Help("its local optimisation and refits");
  }
};

/// What the other rows do with their best hypothesis, done with this one.
template <MinimalModel Model>
void FinishByConsensus(const NormalizedProblem& space, const ConsensusOptions& options, const ModelParameters& model,
                       const Rng& rng, Estimate* estimate) {
  EstimationPriors priors;
  priors.models.push_back(model);
  PrecomputedSampler no_sets({});
  ConsensusResult result = SearchCheckedPoints<Model>(space.points(), space.threshold(), no_sets, options, rng, priors);
  estimate->stats.hypotheses += result.hypotheses;
  if (result.status != Status::kOk) return;
  estimate->model = std::move(result.model);
  estimate->inliers = std::move(result.inliers);
  estimate->score = result.score;
  estimate->sigma = space.unit() * result.sigma;
}

template <MinimalModel Model>
Estimate EstimateModel(const NormalizedProblem& space, const DgsacEstimatorOptions& options, std::uint64_t seed) {
  Estimate estimate;
  const Rng rng = Rng(seed).Fork("dgsac");
  DgsacResult found = EstimateDgsac<Model>(space.points(), options.search, rng);
  estimate.status = found.status;
  estimate.stats.hypotheses = found.hypotheses;
  estimate.stats.unique_minimal_sets = found.unique_minimal_sets;
  estimate.minimal_sets = std::move(found.first_sets);
  if (found.status != Status::kOk) return estimate;
  AcceptModel<Model>(space, found.model, &estimate);
  estimate.sigma = space.unit() * found.sigma;
  if (options.finish == DgsacFinish::kConsensus)
    FinishByConsensus<Model>(space, options.consensus, found.model, rng.Fork("consensus"), &estimate);
  return estimate;
}

/// `consensus` as in `lo_ransac` rows (classical.h), for all models.
DgsacEstimatorOptions DefaultDgsacOptions(Task task) {
  DgsacEstimatorOptions options;
  options.consensus = LoRansacOptions(task).consensus;
  return options;
}

/// DGSAC as a row (dgsac.h): its multi-structure result becomes one model by `choose`. The mask
/// that is reported is at the problem's threshold, as every row's; the score is the inlier count.
class DgsacEstimator : public RobustEstimator {
 public:
  explicit DgsacEstimator(const DgsacEstimatorOptions& options) : options_(options) { CheckOptions(options); }
  Estimate DoRun(const NormalizedProblem& given, std::uint64_t seed) const override {
    return TimedEstimate(given, [&]<MinimalModel Model>(const NormalizedProblem& space) {
      return EstimateModel<Model>(space, options_, seed);
    });
  }

 private:
  DgsacEstimatorOptions options_;
};

const RegisteredEstimator<DgsacEstimatorOptions> kDgsac(
    "dgsac", "Density guided sampling and consensus (docs/dgsac.md). Nothing but `consensus` uses a threshold.",
    DefaultDgsacOptions,
    [](const DgsacEstimatorOptions& options) { return std::make_unique<DgsacEstimator>(options); });

}  // namespace
}  // namespace diffsac
