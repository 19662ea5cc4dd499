#include <memory>

#include "diffsac/estimators/diffsac_engine.h"
#include "diffsac/estimators/diffsac_estimator.h"
#include "diffsac/estimators/presets.h"
#include "lab/config/registered_learned_estimator.h"

namespace diffsac {
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
