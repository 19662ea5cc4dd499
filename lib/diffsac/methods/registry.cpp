#include "diffsac/methods/registry.h"

#include "diffsac/core/resources.h"
#include "diffsac/core/status.h"
#include "diffsac/methods/diffsac_engine.h"
#include "diffsac/methods/learned_model.h"
#include "diffsac/methods/learned_row.h"
#include "diffsac/methods/method_registry.h"

namespace diffsac {
namespace {

const MethodEntry& EntryOf(const Config& config) {
  return Registry<MethodEntry>::Instance().Find(config.Text("type"), config.Where("type"));
}

}  // namespace

std::unique_ptr<Method> MakeMethod(const Config& config, Task task, const MethodContext& context) {
  CheckDevice(context.device);  // also by rows that have no use for it
  return EntryOf(config).make(config, task, context);
}

Config ResolvedRow(const Config& config, Task task, const MethodContext& context) {
  return Config::FromString(EntryOf(config).resolve(config, task, context));
}

Config KeysThatDiffer(const Config& row, const Config& inherited) {
  Config own = row.Without({});
  for (const std::string& key : row.Keys()) {
    if (!inherited.Has(key)) continue;
    if (row.Sub(key).Dump() == inherited.Sub(key).Dump())
      own = own.Without({key});
    else if (!row.Sub(key).Keys().empty())
      own = own.With(key, KeysThatDiffer(row.Sub(key), inherited.Sub(key)));
  }
  return own;
}

TrainedConfig TrainedConfigOf(const Config& row, Task task, const MethodContext& context) {
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

}  // namespace diffsac
