#include "diffsac/train/learner.h"

#include "diffsac/core/status.h"

namespace diffsac {

std::unique_ptr<Learner> MakeLearner(const TrainConfig& options, const torch::Device& device, int threads) {
  if (options.method == "diffsac") return MakeDiffsacLearner(options, device, threads);
  if (options.method == "ng_ransac") return MakeNgRansacLearner(options, device, threads);
  if (options.method == "clnet") return MakeClnetLearner(options, device, threads);
  throw Error("method '" + options.method + "': expected diffsac, ng_ransac or clnet");
}

}  // namespace diffsac
