#pragma once

#include <string>

#include "diffsac/core/options.h"

namespace diffsac {

/// The group `ng_ransac` of a training configuration: Brachmann and Rother, "Neural-guided RANSAC", ICCV 2019.
struct NgRansacTraining {
  /// The first steps train towards a target distribution made of residuals to the ground truth; the others minimise the
  /// expected task loss.
  int initialization_iterations = 2500;
  double target_sigma = 1.0;  ///< the target falls with exp(−r² / 2σ²), σ in multiples of ε
  double rate_factor = 0.1;   ///< of the learning rate after the initialisation
  int pools = 4;              ///< draws of a pool of hypotheses for each problem; their mean loss is the baseline
  int hypotheses = 16;        ///< minimal sets in a pool
  /// "error": of the hypothesis that the consensus of `inference` selects and refines, the error of the task's tables;
  /// "inliers": minus its share of inliers, which needs no truth.
  std::string loss = "error";
  double loss_cap = 4.0;  ///< an error counts at most this many validation thresholds, as 1
  void Bind(OptionsBinder& b);
};

/// The group `clnet` of a training configuration: Zhao et al., "Progressive correspondence pruning by consensus
/// learning", ICCV 2021.
struct ClnetTraining {
  /// α of the adaptive temperature exp(−(d_thr − d) / (α d_thr)) of an inlier at distance d from the true model.
  double temperature = 0.5;
  double regression_weight = 0.5;  ///< of the model regression loss
  double regression_start = 0.2;   ///< share of the iterations after which it counts
  void Bind(OptionsBinder& b);
};

}  // namespace diffsac
