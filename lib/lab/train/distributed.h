#pragma once

#include <torch/types.h>

#include <cstdint>
#include <string>
#include <vector>

#include "lab/torch/process_group.h"
#include "lab/train/training_source.h"

namespace diffsac {

/// One process's part in data-parallel training: n processes together make the steps that one makes alone with the same
/// configuration. Each takes its run of consecutive items out of every joint batch, gradients are summed with weights
/// that make them those of the joint batch, and all processes hold the same network to the last bit. A null group is
/// a process alone, for which nothing is sent and no number changes.
class TrainingTeam {
 public:
  /// Throws Error when there are more processes than items in a batch.
  TrainingTeam(ProcessGroup* group, int batch_size);

  /// The process that validates, logs and writes checkpoints.
  bool main() const { return group_ == nullptr || group_->main(); }
  /// Items of each joint batch that are this process's; sizes differ by at most one.
  int batch() const { return last_ - first_; }
  /// The item of the joint run that is this process's k-th; with k = iteration · batch() a run is resumed.
  std::uint64_t ItemIndex(std::uint64_t k) const;
  /// Threads where none were asked for.
  int threads() const;
  /// The device of this process among those of its machine.
  std::string Device(const std::string& device) const;

  /// Whether it is true of any process.
  bool Any(bool value) const;
  /// Of each weight: this process's share of the sum over all. The mean of the joint batch is the sum over processes of
  /// share times mean.
  std::vector<double> Shares(std::vector<double> weights) const;
  /// Sums over the processes.
  std::vector<double> Sum(std::vector<double> values) const;
  /// Gradients become their sums over the processes; parameters without one are left out, as they are everywhere.
  void SumGradients(const std::vector<torch::Tensor>& parameters) const;
  /// Throws Error unless all processes hold the same text (`what` for the message).
  void CheckSame(const std::string& what, const std::string& text) const;

 private:
  ProcessGroup* group_;
  int batch_size_;
  int first_ = 0;
  int last_;
};

/// The weights of what DiffusionLoss averages over for these items: of the diffusion loss (each copy's points, those of
/// the label positive_weight times) and of the inlier loss (points).
std::vector<double> DiffusionLossWeights(const std::vector<TrainingItem>& items, int copies, double positive_weight);

/// What must be the same everywhere for steps to agree.
std::string WeightsText(const std::vector<torch::Tensor>& parameters);

}  // namespace diffsac
