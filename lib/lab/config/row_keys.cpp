#include "lab/config/row_keys.h"

#include "diffsac/core/status.h"

namespace diffsac {

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
