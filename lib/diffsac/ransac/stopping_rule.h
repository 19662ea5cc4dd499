#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

namespace diffsac {

/// Why the loop ended.
enum class StopReason {
  kNotRun,      ///< No draw was made: the points or the threshold were refused.
  kBudget,      ///< As many draws as were asked for.
  kConfidence,  ///< A better model is less likely than was asked for.
  kExhausted,   ///< The sampler had no more sets.
};

/// When a search ends.
///   kBudget      "budget": after exactly so many draws, unless the sampler runs out
///   kConfidence  "confidence": as soon as uniform draws would have found a better model
enum class Stopping { kBudget, kConfidence };

/// When to end the search. At confidence: once the best model's inliers, at ε, say that a better one would have been
/// drawn with probability `confidence`, by the exact hypergeometric rule; after min_iterations at least and
/// max_iterations at most.
struct StoppingOptions {
  Stopping stopping = Stopping::kBudget;
  int max_iterations = 1000;
  int min_iterations = 0;
  double confidence = 0.99;
};

inline constexpr std::int64_t kNeverEnough = std::numeric_limits<std::int64_t>::max();

/// The probability that a set of `set_size` points drawn without replacement holds inliers only:
/// Π (I − i)/(N − i), the hypergeometric law (not (I/N)^γ, which is too high for few points).
double AllInlierProbability(double inliers, double num_points, int set_size);

/// The least number of draws after which, with probability `confidence`, one at least was good:
/// ⌈log(1 − confidence)/log(1 − p)⌉, at least 1; kNeverEnough for p = 0.
/// probability: p, of one draw being good.
std::int64_t DrawsForConfidence(double probability, double confidence);

/// Decides after each draw whether the search goes on.
class StoppingRule {
 public:
  /// N and γ of the problem. weights: N values in proportion to which points are drawn; empty: alike.
  StoppingRule(const StoppingOptions& options, std::int64_t num_points, int set_size, Eigen::VectorXd weights = {})
      : options_(options), num_points_(num_points), set_size_(set_size), weights_(std::move(weights)) {}
  /// So many points of a set are drawn (MinimalSampler::DrawnPoints).
  void SetDrawnPoints(int count) { set_size_ = count; }
  /// The best model so far has so many inliers, all points being drawn alike.
  void Update(std::int64_t inliers);
  /// The best model so far has these inliers, a mask. Where points are drawn by weights, inliers count as the share of
  /// all weight that they have.
  void Update(std::span<const std::uint8_t> inliers);
  /// Of the best model.
  std::int64_t inliers() const { return inliers_; }
  /// kNotRun: go on.
  StopReason After(std::int64_t iterations) const;
  /// Whether so many draws have a set of inliers alone with a probability of .99, whatever the confidence asked for.
  bool Finds(std::int64_t iterations) const;

 private:
  /// inliers: as many alike ones as are drawn as often.
  void Expect(double inliers);

  StoppingOptions options_;
  std::int64_t num_points_;
  int set_size_;
  Eigen::VectorXd weights_;
  std::int64_t inliers_ = 0;
  double probability_ = 0.0;  ///< Of one draw being good.
  std::int64_t needed_ = kNeverEnough;
};

}  // namespace diffsac
