#include "lab/train/distributed.h"

#include <torch/torch.h>

#include <algorithm>
#include <cstdio>

#include "diffsac/core/parallel.h"
#include "diffsac/core/random.h"
#include "diffsac/core/status.h"

namespace diffsac {

TrainingTeam::TrainingTeam(ProcessGroup* group, int batch_size)
    : group_(group), batch_size_(batch_size), last_(batch_size) {
  if (group_ == nullptr) return;
  if (group_->size() > batch_size_)
    throw Error("train.batch_size: " + std::to_string(batch_size_) + " problems a step for " +
                std::to_string(group_->size()) + " processes; expected at least one for each");
  const auto bound = [&](std::int64_t rank) { return static_cast<int>(rank * batch_size_ / group_->size()); };
  first_ = bound(group_->rank());
  last_ = bound(group_->rank() + 1);
}

std::uint64_t TrainingTeam::ItemIndex(std::uint64_t k) const {
  const auto mine = static_cast<std::uint64_t>(batch());
  return k / mine * static_cast<std::uint64_t>(batch_size_) + static_cast<std::uint64_t>(first_) + k % mine;
}

int TrainingTeam::threads() const { return group_ == nullptr ? HardwareThreads() : DefaultThreads(group_->place()); }

std::string TrainingTeam::Device(const std::string& device) const {
  return group_ == nullptr ? device : LocalDevice(group_->place(), device);
}

bool TrainingTeam::Any(bool value) const { return Sum({value ? 1.0 : 0.0}).front() > 0.0; }

std::vector<double> TrainingTeam::Shares(std::vector<double> weights) const {
  std::vector<double> totals = Sum(weights);
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = totals[i] > 0.0 ? weights[i] / totals[i] : 0.0;
  return weights;
}

std::vector<double> TrainingTeam::Sum(std::vector<double> values) const {
  if (group_ != nullptr) group_->Sum(&values);
  return values;
}

void TrainingTeam::SumGradients(const std::vector<torch::Tensor>& parameters) const {
  if (group_ == nullptr) return;
  std::vector<torch::Tensor> gradients;
  for (const auto& parameter : parameters)
    if (parameter.grad().defined()) gradients.push_back(parameter.grad());
  group_->Sum(gradients);
}

void TrainingTeam::CheckSame(const std::string& what, const std::string& text) const {
  if (group_ == nullptr) return;
  std::vector<double> digests(static_cast<std::size_t>(group_->size()), 0.0);
  digests[static_cast<std::size_t>(group_->rank())] = static_cast<double>(Rng().Fork(text).Seed() >> 11);  // Exact.
  digests = Sum(std::move(digests));
  const auto other = std::find_if(digests.begin(), digests.end(), [&](double d) { return d != digests.front(); });
  if (other != digests.end())
    throw Error("processes 0 and " + std::to_string(other - digests.begin()) + " have different " + what +
                "; all must see the same files and be started with the same options");
}

std::vector<double> DiffusionLossWeights(const std::vector<TrainingItem>& items, int copies, double positive_weight) {
  double positives = 0.0, points = 0.0;
  for (const TrainingItem& item : items) {
    for (const auto& label : item.labels) positives += static_cast<double>(label.size());
    points += static_cast<double>(item.inliers.size());
  }
  return {copies * points + (positive_weight - 1.0) * positives, points};
}

std::string WeightsText(const std::vector<torch::Tensor>& parameters) {
  const torch::NoGradGuard no_grad;
  double sum = 0.0, magnitude = 0.0;
  for (const auto& parameter : parameters) {
    sum += parameter.sum(torch::kDouble).item<double>();
    magnitude += parameter.abs().sum(torch::kDouble).item<double>();
  }
  char text[64];
  std::snprintf(text, sizeof text, "%.17g %.17g", sum, magnitude);
  return text;
}

}  // namespace diffsac
