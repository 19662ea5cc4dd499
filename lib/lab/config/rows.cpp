#include <memory>
#include <utility>

#include "diffsac/core/status.h"
#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/diffsac_estimator.h"
#include "diffsac/estimate/diffsac_model.h"
#include "diffsac/estimate/presets.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/estimator_registry.h"
#include "lab/config/registered_learned_estimator.h"

namespace diffsac {
namespace {

/// The presets of estimate/presets.h that a search without a network has, with the sampler of its type.
ClassicalOptions OfPreset(const std::string& preset, Task task, const ClassicalOptions& defaults) {
  if (preset == ToString(Preset::kDefault)) return defaults;
  ClassicalOptions options = preset == ToString(Preset::kSeveral) ? SeveralInstances(task) : RecommendedClassical(task);
  options.sampling = defaults.sampling;
  return options;
}

struct RegisteredClassical : RegisteredEstimator<ClassicalOptions> {
  RegisteredClassical(const std::string& type, const std::string& help, Defaults defaults)
      : RegisteredEstimator(
            type, help, {ToString(Preset::kDefault), ToString(Preset::kRecommended), ToString(Preset::kSeveral)},
            [defaults = std::move(defaults)](Task task, const std::string& preset) {
              return OfPreset(preset, task, defaults(task));
            },
            [](const ClassicalOptions& options) { return std::make_unique<ClassicalEstimator>(options); }) {}
};

/// `lo_ransac` with another sampler.
RegisteredClassical::Defaults LoRansacFrom(MinimalSamplerKind sampler) {
  return [sampler](Task task) {
    ClassicalOptions options = LoRansacOptions(task);
    options.sampling.sampler = sampler;
    return options;
  };
}

const RegisteredClassical kRansac("ransac", "Inlier count, one least squares on the inliers.",
                                  [](Task) { return ClassicalOptions(); });
const RegisteredClassical kLoRansac("lo_ransac",
                                    "MSAC, local optimisation, iterated refits (Chum, Matas, Kittler 2003).",
                                    LoRansacOptions);
const RegisteredClassical kProsac("prosac", "`lo_ransac` with sets in the order of quality (Chum, Matas 2005).",
                                  LoRansacFrom(MinimalSamplerKind::kProsac));
const RegisteredClassical kNapsac("napsac", "`lo_ransac` with sets from neighbourhoods (Torr et al. 2002).",
                                  LoRansacFrom(MinimalSamplerKind::kNapsac));
const RegisteredClassical kProgressiveNapsac("p_napsac",
                                             "`lo_ransac` with sets from growing neighbourhoods (Barath et al. 2020).",
                                             LoRansacFrom(MinimalSamplerKind::kProgressiveNapsac));
const RegisteredClassical kGcRansac("gc_ransac", "`lo_ransac` with graph-cut local optimisation (Barath, Matas 2018).",
                                    [](Task task) {
                                      ClassicalOptions options = LoRansacOptions(task);
                                      options.consensus.local_optimization = LocalOptimization::kGraphCut;
                                      return options;
                                    });
const RegisteredClassical kMagsac("magsac_pp",
                                  "MAGSAC++ score, reweighted local optimisation and refit (Barath et al. 2020).",
                                  [](Task task) {
                                    ClassicalOptions options = LoRansacOptions(task);
                                    ConsensusOptions& consensus = options.consensus;
                                    consensus.score = consensus.final_score = ScoreKind::kMagsac;
                                    consensus.score_threshold_factor = 2.5;
                                    consensus.local_optimization = LocalOptimization::kReweighted;
                                    consensus.refit = Refit::kReweighted;
                                    consensus.refit_threshold_factor = 1.0;
                                    return options;
                                  });
const RegisteredClassical kExhaustive(
    "exhaustive", "Lines and planes: every minimal set, the best 5 refitted by expectation maximisation.",
    [](Task task) {
      if (IsTwoView(task)) throw Error("exhaustive searches lines and planes only; too many minimal sets");
      ClassicalOptions options = LoRansacOptions(task);
      options.exhaustive = true;
      options.max_iterations = 2'000'000;
      ConsensusOptions& consensus = options.consensus;
      consensus.local_optimization = LocalOptimization::kNone;
      consensus.refit = Refit::kMixture;
      consensus.refit_rounds = 1;
      consensus.refit_threshold_factor = 1.0;
      consensus.refit_candidates = 5;
      consensus.final_score = ScoreKind::kMlesac;
      return options;
    });

}  // namespace

static void CheckRow(const Config& row, const DiffsacOptions& options, const DiffsacModel& network) {
  const bool by_confidence = options.consensus.stopping != Stopping::kBudget;
  CheckRowKeys(row, {{"sampler", !network.options.direct, "the network was trained without diffusion"},
                     {"consensus.max_iterations", by_confidence,
                      "it needs consensus.stopping: confidence; the budget is num_diffusion_samples, "
                      "num_guided_samples and num_uniform_samples"}});
  CheckSharedKeys(row, network);
}

namespace {

std::shared_ptr<const DiffsacModel> Load(const TrainedConfig& trained, const DiffsacOptions& options,
                                         const EstimatorContext& context) {
  return LoadDiffsac(trained, options.engine, context.device);
}

const LearnedPresets<DiffsacOptions> kPresets = {
    {ToString(Preset::kDefault), ToString(Preset::kRecommended), ToString(Preset::kPaper)},
    [](Task task, const std::string& preset) {
      return preset == ToString(Preset::kPaper) ? PaperDiffsac() : LearnedProsac(task);
    }};

const RegisteredLearnedEstimator<DiffsacEstimator, DiffsacOptions, DiffsacModel> kDiffsac(
    "diffsac", "Minimal sets guided by confidences that a diffusion process draws.", DiffsacOptions(), Load, kPresets);

}  // namespace

}  // namespace diffsac
