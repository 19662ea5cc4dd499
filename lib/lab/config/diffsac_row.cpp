#include <memory>

#include "diffsac/estimate/diffsac_estimator.h"
#include "diffsac/estimate/diffsac_model.h"
#include "diffsac/estimate/presets.h"
#include "lab/config/registered_learned_estimator.h"

namespace diffsac {

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
