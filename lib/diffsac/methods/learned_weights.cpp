#include "diffsac/methods/learned_weights.h"

#include <torch/torch.h>

#include "diffsac/denoiser/checkpoint.h"
#include "diffsac/denoiser/denoiser.h"
#include "diffsac/methods/trained_config.h"

namespace diffsac {
namespace {

// The number of columns, which a network is made for.
int FeatureWidth(const PointFeaturesOptions& options, Task task) { return PointFeatures(options, task).width(); }

}  // namespace

void LearnedWeights::MoveTo(const torch::Device& target) {
  network->to(target);
  device = target;
}

std::shared_ptr<LearnedWeights> MakeNgRansacWeights(Task task, const NgRansacNetworkOptions& options, Rng rng) {
  auto network = std::make_shared<NgRansacNetwork>(options, FeatureWidth(options.features, task), rng);
  return std::make_shared<LearnedWeights>(task, options.features, std::move(network));
}

std::shared_ptr<LearnedWeights> MakeClnetWeights(Task task, const ClnetNetworkOptions& options, Rng rng) {
  auto network = std::make_shared<ClnetNetwork>(options, FeatureWidth(options.features, task), rng);
  return std::make_shared<LearnedWeights>(task, options.features, std::move(network));
}

std::shared_ptr<LearnedWeights> LoadLearnedWeights(const std::string& method, const std::string& checkpoint, Task task,
                                                   const torch::Device& device) {
  const auto trained = ReadTrainedConfig(checkpoint, method, task);
  const auto options = trained.config.Sub("network");
  auto weights = method == "clnet"
                     ? MakeClnetWeights(task, ReadOptions<ClnetNetworkOptions>(options), Rng(trained.seed))
                     : MakeNgRansacWeights(task, ReadOptions<NgRansacNetworkOptions>(options), Rng(trained.seed));
  LoadAverage(checkpoint, *weights->network);
  weights->network->eval();
  weights->facts = trained.facts;
  weights->facts.parameters = CountParameters(*weights->network);
  weights->MoveTo(device);
  return weights;
}

}  // namespace diffsac
