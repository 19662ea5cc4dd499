#pragma once

// A random problem for each model there is, every source over it, and every value of every option.

#include <cmath>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "consensus/random_problems.h"
#include "diffsac/consensus/make_source.h"
#include "diffsac/consensus/two_view_consensus.h"
#include "geometry/two_view_problems.h"

namespace diffsac::testing {

/// Points and the threshold that suits their noise.
struct ModelProblem {
  PointMatrix points;
  double threshold = 0.0;
  int outliers = 0;  ///< that many, and the first ones
  ModelParameters truth;
};

/// Lines and planes with σ = .03 in a box of side 10; correspondences in images of about 1000 pixels with σ = .5 px,
/// for E in normalised coordinates.
template <MinimalModel Model>
ModelProblem MakeModelProblem(int count, double outlier_ratio, Rng rng) {
  ModelProblem problem;
  problem.outliers = static_cast<int>(std::lround(outlier_ratio * count));
  if constexpr (Model::kDimension != 4) {
    const auto hyperplane = MakeRandomProblem<Model::kDimension>(count, outlier_ratio, 0.03, rng);
    problem.points = hyperplane.points;
    problem.truth = hyperplane.truth;
    problem.threshold = 0.1;
    return problem;
  } else {
    TwoViewProblem views = RandomProblem(count, rng, 0.5);
    problem.truth = views.fundamental;
    if (std::is_same_v<Model, Homography>) {
      const Matrix3Parameters homography = RandomHomography(rng);
      views.pixels = HomographyPoints(homography, count, rng, 0.5);
      problem.truth = homography;
    }
    for (int i = 0; i < problem.outliers; ++i)
      for (int j = 0; j < 4; ++j) views.pixels(i, j) = rng.Uniform(0.0, 1000.0);
    problem.points = views.pixels;
    problem.threshold = 2.0;
    if (!std::is_same_v<Model, Essential>) return problem;
    problem.points = NormalizedCoordinates(views.pixels, views.k1, views.k2);
    problem.threshold /= views.k1(0, 0);
    problem.truth = views.essential;
    return problem;
  }
}

/// An order of the points as good as a matcher's: outliers tend to come last.
inline std::vector<double> MakeQuality(int count, int outliers, Rng rng) {
  std::vector<double> quality(count);
  for (int i = 0; i < count; ++i) quality[i] = (i < outliers ? 0.3 : 0.0) + rng.Uniform();
  return quality;
}

/// Every source over the same points, by name; owns what they borrow.
class AllSources {
 public:
  AllSources(const PointMatrix& points, int set_size, const std::vector<double>& quality) {
    for (const char* name : {"uniform", "exhaustive", "prosac", "napsac", "p_napsac", "weighted"}) {
      SourceOptions options;
      options.source = name;
      Add(name, MakeHypothesisSource(options, points, set_size, quality, quality));
    }
    const int count = static_cast<int>(points.rows());
    UniformSource().DrawBlock(count, set_size, 0, 100, Rng(5), &given_);
    Add("given", std::make_unique<GivenSource>(given_));
    Rng rng(6);
    for (int copy = 0; copy < 100; ++copy)
      for (int i = 0; i < count; ++i) confidences_.push_back(static_cast<float>(rng.Normal() - quality[i]));
    Add("confidence_maximum", std::make_unique<ConfidenceSource>(confidences_, Selection::kMaximum, true, 1.0));
    Add("confidence_gumbel", std::make_unique<ConfidenceSource>(confidences_, Selection::kProbabilistic, false, 1.0));
  }
  AllSources(const AllSources&) = delete;
  AllSources& operator=(const AllSources&) = delete;

  auto begin() const { return sources_.begin(); }
  auto end() const { return sources_.end(); }

 private:
  void Add(const char* name, std::unique_ptr<HypothesisSource> source) {
    sources_.emplace_back(name, std::move(source));
  }

  std::vector<int> given_;
  std::vector<float> confidences_;
  std::vector<std::pair<std::string, std::unique_ptr<HypothesisSource>>> sources_;
};

inline constexpr const char* kScores[] = {"inlier_count", "msac", "gaussian_uniform", "magsac_pp"};
inline constexpr const char* kOptimizers[] = {"none", "lo_ransac", "irls", "gc_ransac", "lm"};
inline constexpr const char* kRefits[] = {"none", "inliers", "iterated", "em", "irls"};

/// Calls function(options) for every score and optimiser; the other options run through their values on the way, from
/// another place for another `shift`.
template <class Function>
void ForEachCombination(int shift, const Function& function) {
  int i = shift;
  for (const char* score : kScores)
    for (const char* optimizer : kOptimizers) {
      ConsensusOptions options;
      options.score = score;
      options.local_optimization = optimizer;
      options.final_score = kScores[i % 4];
      options.refit = kRefits[(i / 2) % 5];
      options.final_refinement = i % 2 ? "lm" : "none";
      options.stopping = i % 3 ? "budget" : "confidence";
      options.sprt = i % 7 == 0;
      options.refit_candidates = 1 + i % 3;
      options.local_samples = 4;
      ++i;
      function(options);
    }
}

}  // namespace diffsac::testing
