// The loop with policies of somebody else's: it asks for no more than policies.h says.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/ransac/loop.h"

namespace diffsac::ransac {
namespace {

/// A number on a line, from one point.
struct Place {
  using Parameters = Eigen::Matrix<double, 1, 1>;
  static constexpr int kDimension = 1, kMinimalSize = 1, kMaxSolutions = 1;
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
    (*out)[0] = points(set[0], 0);
    return 1;
  }
  static bool Fit(const PointMatrix&, const Eigen::VectorXd&, Parameters*) { return false; }
  static double Residual(const Parameters& model, const double* point) { return std::abs(model[0] - *point); }
};

/// Points within 1 count.
struct CountScorer {
  const PointMatrix& points;
  double operator()(const Place::Parameters& model, double) const { return (Residuals(model).array() <= 1.0).count(); }
  Eigen::VectorXd Residuals(const Place::Parameters& model) const {
    return (points.col(0).array() - model[0]).abs().matrix();
  }
};

/// Moves each model to the right by `step`, once, and counts how often it is asked.
struct ShiftOptimizer {
  double step;
  int asked = 0;
  ScoredModel<Place> operator()(const ScoredModel<Place>& found, const int*, double, int* fits) {
    ++asked, ++*fits;
    return {Place::Parameters::Constant(found.model[0] + step), found.score + 0.5};
  }
  ScoredModel<Place> Again(const Place::Parameters& model, int*) { return {model, -1.0}; }
};

/// Ends after so many draws, or once there are two inliers.
struct TwoInliers {
  std::int64_t most, found = 0;
  void SetDrawnPoints(int) {}
  void Update(const std::vector<std::uint8_t>& inliers) { found = std::count(inliers.begin(), inliers.end(), 1); }
  std::int64_t inliers() const { return found; }
  StopReason After(std::int64_t iterations) const {
    if (found >= 2) return StopReason::kConfidence;
    return iterations >= most ? StopReason::kBudget : StopReason::kNotRun;
  }
  bool Finds(std::int64_t) const { return false; }
};

/// The best candidate as it is.
struct AsItIs {
  const CountScorer& scorer;
  template <class Candidates>
  std::optional<ScoredModel<Place>> operator()(const Candidates& candidates, int*) const {
    if (candidates.empty()) return std::nullopt;
    return ScoredModel<Place>{candidates.front().model, candidates.front().score};
  }
  std::vector<std::uint8_t> Inliers(const Place::Parameters& model) const {
    const Eigen::VectorXd residuals = scorer.Residuals(model);
    std::vector<std::uint8_t> mask(residuals.size());
    for (Eigen::Index i = 0; i < residuals.size(); ++i) mask[i] = residuals[i] <= 1.0;
    return mask;
  }
  template <class Candidates>
  void Complete(const Candidates& candidates, const ScoredModel<Place>& chosen, ConsensusResult* result) const {
    result->status = Status::kOk;
    result->model = chosen.model;
    result->score = chosen.score;
    result->other_inliers = static_cast<int>(candidates.size());
  }
};

struct Outcome {
  ConsensusResult result;
  int asked;
};

Outcome Run(const std::vector<int>& sets, const LoopOptions& options,
            const std::vector<Place::Parameters>& given = {}) {
  PointMatrix points(6, 1);
  points << 0.0, 10.0, 20.0, 30.0, 30.5, 50.0;
  PrecomputedSampler sampler(sets);
  const CountScorer scorer{points};
  ShiftOptimizer optimize{0.25};
  TwoInliers stop{options.max_iterations};
  const AsItIs refine{scorer};
  const auto result = Search<Place>(points, Policies{sampler, scorer, optimize, stop, refine}, options, given);
  return {result, optimize.asked};
}

TEST_CASE("other policies stop by their own rule") {
  const auto [result, asked] = Run({0, 1, 2, 3, 4, 5}, {.max_iterations = 6});
  CHECK(result.stop == StopReason::kConfidence);
  CHECK(result.iterations == 4);
  CHECK(result.model[0] == 30.25);
  CHECK(result.score == 2.5);
  // The first draw and the first of two inliers; others score no more than the best draw.
  CHECK(asked == 2);
  CHECK(result.hypotheses == 4 + 2);
  CHECK(result.unique_minimal_sets == 4);
}

TEST_CASE("other policies end with budget or sets") {
  CHECK(Run({0, 1, 2}, {.max_iterations = 2}).result.stop == StopReason::kBudget);
  CHECK(Run({0, 1, 2}, {.max_iterations = 9}).result.stop == StopReason::kExhausted);
  CHECK(Run({}, {.max_iterations = 9}).result.status == Status::kNoModel);
}

TEST_CASE("Given models come first in a loop") {
  const auto [result, asked] = Run({0, 1, 2, 3}, {.max_iterations = 4}, {Place::Parameters::Constant(30.0)});
  CHECK(result.stop == StopReason::kConfidence);
  CHECK(result.iterations == 0);
  CHECK(asked == 1);
  CHECK(result.model[0] == 30.25);
}

TEST_CASE("A loop keeps as many candidates as asked") {
  const auto [result, asked] = Run({0, 1, 2, 5}, {.max_iterations = 4, .candidates = 3, .threshold = 1.0});
  CHECK(result.other_inliers == 3);
  CHECK(asked == 1);
}

}  // namespace
}  // namespace diffsac::ransac
