#pragma once

#include <vector>

#include "diffsac/consensus/scorer.h"
#include "diffsac/core/random.h"

namespace diffsac {

/// Wald's sequential probability ratio test of a model (Matas and Chum, "Randomized RANSAC with sequential probability
/// ratio test", ICCV 2005). Points are looked at in a random order that is fixed for a problem; a model is dropped once
/// the likelihood ratio of "bad" (a point is an inlier with probability δ) to "good" (ε) exceeds the threshold A. A
/// good model is lost with probability 1/A, so results can differ from those without the test, and the number of draws
/// for a confidence grows by 1/(1 − 1/A).
///
/// ε is raised to the inlier share of each new best model, δ follows the dropped models; A is the best threshold for
/// them (section 3.1), given that solving a set costs as much as `kSolveCost` residuals.
class SequentialTest {
 public:
  struct Outcome {
    bool accepted = true;
    int tested = 0;   ///< Points looked at.
    int inliers = 0;  ///< Inliers among them.
  };

  explicit SequentialTest(int solutions_per_set);

  /// Tests a model on the scorer's points, which must be in random order.
  template <MinimalModel Model>
  Outcome Test(const Scorer<Model>& shuffled, const typename Model::Parameters& model, double threshold) const {
    Outcome outcome;
    double ratio = 1.0;
    std::array<double, kBlock> residuals;
    for (int begin = 0; begin < shuffled.size(); begin += kBlock) {
      const int end = std::min(begin + kBlock, shuffled.size());
      shuffled.Residuals(model, begin, end, residuals.data());
      for (int i = 0; i < end - begin; ++i) {
        const bool inlier = residuals[i] <= threshold;
        ++outcome.tested;
        outcome.inliers += inlier ? 1 : 0;
        ratio *= inlier ? inlier_factor_ : outlier_factor_;
        if (ratio > decision_threshold_) {
          outcome.accepted = false;
          return outcome;
        }
      }
    }
    return outcome;
  }

  /// Takes in a dropped model; true when the test has changed.
  bool AddRejected(const Outcome& outcome);
  /// Takes in the inlier share of a new best model; true when the test has changed.
  bool AddBest(double inlier_share);
  /// 1 − 1/A, the probability that a good model passes.
  double PassProbability() const;
  double decision_threshold() const { return decision_threshold_; }

 private:
  void Design();

  static constexpr int kBlock = 64;
  double solutions_per_set_;
  double good_share_ = 0.1;  ///< ε, from the paper's start.
  double bad_share_ = 0.01;  ///< δ, likewise.
  double tested_ = 0.0, tested_inliers_ = 0.0;
  double inlier_factor_ = 1.0, outlier_factor_ = 1.0, decision_threshold_ = 0.0;
};

/// The test on one problem's points, in a random order.
template <MinimalModel Model>
class SequentialFilter {
 public:
  /// threshold: of an inlier, linear. Copies the points.
  SequentialFilter(const PointMatrix& points, double threshold, Rng rng)
      : points_(Shuffled(points, rng)), scorer_(points_), threshold_(threshold), test_(Model::kMaxSolutions) {}
  SequentialFilter(const SequentialFilter&) = delete;
  SequentialFilter& operator=(const SequentialFilter&) = delete;

  SequentialTest::Outcome Test(const typename Model::Parameters& model) const {
    return test_.Test(scorer_, model, threshold_);
  }
  bool AddRejected(const SequentialTest::Outcome& outcome) { return test_.AddRejected(outcome); }
  bool AddBest(double inlier_share) { return test_.AddBest(inlier_share); }
  double PassProbability() const { return test_.PassProbability(); }

 private:
  static PointMatrix Shuffled(const PointMatrix& points, Rng& rng) {
    const std::vector<int> order = rng.Permutation(static_cast<int>(points.rows()));
    return points(order, Eigen::all);
  }

  PointMatrix points_;
  Scorer<Model> scorer_;
  double threshold_;
  SequentialTest test_;
};

}  // namespace diffsac
