#include "lab/train/learner.h"

namespace diffsac {

std::unique_ptr<Learner> MakeLearner(const TrainConfig& options, const torch::Device& device, int threads) {
  return Registry<LearnerEntry>::Instance().Find(options.method, "method").make(options, device, threads);
}

}  // namespace diffsac
