#include "diffsac/methods/registry.h"

#include "diffsac/core/status.h"
#include "diffsac/denoiser/checkpoint.h"
#include "diffsac/methods/classical.h"
#include "diffsac/methods/dgsac_method.h"
#include "diffsac/methods/diffsac_method.h"
#include "diffsac/methods/opencv_usac.h"

namespace diffsac {
namespace {

const std::vector<std::string> kTypes = {"diffsac",    "ransac",    "lo_ransac", "prosac",         "napsac",
                                         "p_napsac",   "gc_ransac", "magsac_pp", "usac",           "opencv_magsac",
                                         "exhaustive", "dgsac",     "theil_sen", "line_posterior", "oracle"};

// A row's own keys override the checkpoint's `inference` group, so that a row says only what it changes.
struct DiffsacRow {
  std::string checkpoint;
  DiffsacOptions options;
  void Bind(OptionsBinder& b) {
    for (const char* key : {"name", "type", "label", "paper", "conditions", "max_problems"}) b.Ignore(key);
    b.Field("checkpoint", checkpoint);
    options.Bind(b);
  }
};

std::unique_ptr<Method> MakeDiffsac(const Config& config, Task task, const MethodContext& context) {
  std::string checkpoint = context.checkpoint_override;
  if (checkpoint.empty()) checkpoint = ReadOptions<DiffsacRow>(config).checkpoint;
  if (checkpoint.empty()) throw Error(config.Where() + ": method 'diffsac' needs a checkpoint (key, or --checkpoint)");
  const auto network = LoadNetwork(checkpoint, task, DeviceFromString(context.device));
  const auto trained = Config::FromString(ReadCheckpointInfo(checkpoint).config, checkpoint + " (its configuration)");
  DiffsacRow row;
  row.options = ReadOptions<DiffsacOptions>(trained.Sub("inference"));
  row = ReadOptions<DiffsacRow>(config, row);
  return std::make_unique<DiffsacMethod>(network, row.options, context.threads);
}

}  // namespace

std::unique_ptr<Method> MakeMethod(const Config& config, Task task, const MethodContext& context) {
  const std::string type = config.Text("type");
  if (type == "diffsac") return MakeDiffsac(config, task, context);
  if (auto method = MakeClassicalMethod(type, config, task)) return method;
  if (auto method = MakeDgsacMethod(type, config, task)) return method;
  if (auto method = MakeOpencvMethod(type, config, task)) return method;
  throw Error(config.Where("type") + ": unknown method type '" + type + "'; did you mean '" +
              NearestWord(type, kTypes) + "'?");
}

}  // namespace diffsac
