#include "diffsac/methods/registry.h"

#include "diffsac/core/status.h"
#include "diffsac/data/tasks.h"
#include "diffsac/methods/classical.h"
#include "diffsac/methods/clnet.h"
#include "diffsac/methods/dgsac_method.h"
#include "diffsac/methods/diffsac_method.h"
#include "diffsac/methods/learned_network.h"
#include "diffsac/methods/ng_ransac.h"
#include "diffsac/methods/opencv_usac.h"
#include "diffsac/methods/weighted_method.h"

namespace diffsac {
namespace {

const std::vector<std::string> kTypes = {"diffsac",    "ransac",    "lo_ransac", "prosac",         "napsac",
                                         "p_napsac",   "gc_ransac", "magsac_pp", "usac",           "opencv_magsac",
                                         "exhaustive", "dgsac",     "theil_sen", "line_posterior", "oracle",
                                         "ng_ransac",  "clnet"};

// A row's own keys override the checkpoint's `inference` group, so that a row says only what it changes.
template <class Options>
struct LearnedRow {
  std::string checkpoint;
  Options options;
  Task task;
  void Bind(OptionsBinder& b) {
    for (const char* key : {"name", "type", "label", "paper", "conditions", "max_problems"}) b.Ignore(key);
    b.Field("checkpoint", checkpoint);
    BindModel(b, task, &options.model);
    options.Bind(b);
  }
};

// --checkpoint is for the rows of the method that trained it.
std::string OverrideFor(const std::string& type, const MethodContext& context) {
  const auto& path = context.checkpoint_override;
  return !path.empty() && TrainedMethod(path) == type ? path : "";
}

template <class Learned, class Options, class Load>
std::unique_ptr<Method> MakeLearned(const Config& config, Task task, const MethodContext& context, Options defaults,
                                    Load load) {
  const std::string type = config.Text("type");
  LearnedRow<Options> row{{}, std::move(defaults), task};
  std::string checkpoint = OverrideFor(type, context);
  if (checkpoint.empty() && config.Has("checkpoint")) checkpoint = config.Text("checkpoint");
  if (checkpoint.empty())
    throw Error(config.Where() + ": method '" + type + "' needs a checkpoint (key, or --checkpoint)");
  const auto network = load(checkpoint, DeviceFromString(context.device));
  const auto trained = ReadTrainedConfig(checkpoint, type, task);
  row.options = ReadStoredOptions(trained.config.Sub("inference"), row.options);
  row.options.model = trained.model;
  row = ReadOptions(config, row);
  CheckRow(config, row.options, *network);
  return std::make_unique<Learned>(network, row.options, context.threads);
}

template <class Network>
std::unique_ptr<Method> MakeWeighted(const Config& config, Task task, const MethodContext& context) {
  return MakeLearned<WeightedMethod>(config, task, context, DefaultWeightedOptions(Network::kMethod),
                                     [&](const std::string& checkpoint, const torch::Device& device) {
                                       return LoadLearnedWeights<Network>(checkpoint, task, device);
                                     });
}

std::unique_ptr<Method> MakeDiffsac(const Config& config, Task task, const MethodContext& context) {
  return MakeLearned<DiffsacMethod>(config, task, context, DiffsacOptions(),
                                    [&](const std::string& checkpoint, const torch::Device& device) {
                                      return LoadNetwork(checkpoint, task, device);
                                    });
}

}  // namespace

std::unique_ptr<Method> MakeMethod(const Config& config, Task task, const MethodContext& context) {
  const std::string type = config.Text("type");
  if (type == "diffsac") return MakeDiffsac(config, task, context);
  if (type == "ng_ransac") return MakeWeighted<NgRansacNetwork>(config, task, context);
  if (type == "clnet") return MakeWeighted<ClnetNetwork>(config, task, context);
  if (auto method = MakeClassicalMethod(type, config, task)) return method;
  if (auto method = MakeDgsacMethod(type, config, task)) return method;
  if (auto method = MakeOpencvMethod(type, config, task)) return method;
  throw Error(config.Where("type") + ": unknown method type '" + type + "'; did you mean '" +
              NearestWord(type, kTypes) + "'?");
}

}  // namespace diffsac
