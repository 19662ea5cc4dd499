#include "lab/config/make_estimator.h"

#include "diffsac/core/status.h"
#include "diffsac/estimate/diffsac_model.h"
#include "diffsac/estimate/estimator.h"
#include "diffsac/estimate/learned_model.h"
#include "lab/config/estimator_registry.h"
#include "lab/config/paths.h"
#include "lab/config/registered_learned_estimator.h"
#include "lab/config/yaml.h"

namespace diffsac {
namespace {

const EstimatorEntry& EntryOf(const Config& config) {
  return Registry<EstimatorEntry>::Instance().Find(config.Text("type"), config.Where("type"));
}

}  // namespace

TableRow MakeRow(const Config& config, Task task, const EstimatorContext& context) {
  CheckDevice(context.device);  // also by rows that have no use for it
  TableRow row = EntryOf(config).make(config, task, context);
  if (row.estimator() != nullptr && row.estimator()->SearchesAgain())
    row.SetWithoutScores(
        [kept = CachedEstimator(task, {})]() -> const RobustEstimator& { return kept->WithoutScores(); });
  return row;
}

std::unique_ptr<RobustEstimator> MakeEstimator(const Config& config, Task task, const EstimatorContext& context) {
  auto estimator = MakeRow(config, task, context).TakeEstimator();
  if (estimator == nullptr)
    throw Error(config.Where("type") + ": '" + config.Text("type") +
                "' is shown a table's examples: it estimates nothing else");
  return estimator;
}

Config ResolvedRow(const Config& config, Task task, const EstimatorContext& context) {
  return EntryOf(config).resolve(config, task, context);
}

Config KeysThatDiffer(const Config& row, const Config& inherited) {
  Config own = row.Without({});
  for (const std::string& key : row.Keys()) {
    if (!inherited.Has(key)) continue;
    if (ToYaml(row.Sub(key)) == ToYaml(inherited.Sub(key)))
      own = own.Without({key});
    else if (!row.Sub(key).Keys().empty())
      own = own.With(key, KeysThatDiffer(row.Sub(key), inherited.Sub(key)));
  }
  return own;
}

TrainedConfig TrainedConfigOf(const Config& row, Task task, const EstimatorContext& context) {
  const std::string type = row.Text("type");
  const std::string& given = context.checkpoint_override;
  if (!given.empty()) {
    TrainedConfig trained = ReadTrainedConfig(given);
    if (trained.method == type) {
      CheckTrainedFor(trained, type, task);
      return trained;
    }
  }
  if (row.Has("checkpoint") && !row.Text("checkpoint").empty())
    return ReadTrainedConfig(RequiredPath(row.Sub("checkpoint"), "checkpoint"), type, task);
  throw Error(row.Where() + ": method '" + type + "' needs a checkpoint (key, or --checkpoint)");
}

void CheckRowKeys(const Config& row, std::initializer_list<RowKey> keys) {
  for (const RowKey& key : keys) {
    if (key.acts || !row.Has(key.key)) continue;
    if (key.neutral != nullptr && row.Text(key.key) == key.neutral) continue;
    throw Error(row.Where(key.key) + ": changes nothing in this row: " + key.reason);
  }
}

void CheckSharedKeys(const Config& row, const LearnedModel& network) {
  const bool residual = network.feature_options.Has(PointFeature::kResidual);
  const char* features = "the network sees no residual features";
  CheckRowKeys(row, {{"feature_hypotheses", residual, features, "false"}, {"residual_draws", residual, features, "0"}});
}

}  // namespace diffsac
