#pragma once

// A random problem for each model there is, every source over it, and every value of every option.

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/ransac/sample_consensus.h"
#include "diffsac/ransac/samplers/confidence_sampler.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"
#include "diffsac/ransac/samplers/weighted_sampler.h"
#include "geometry/cloud_scene.h"
#include "geometry/two_view_problems.h"
#include "ransac/absolute_pose_scene.h"
#include "ransac/random_problems.h"

namespace diffsac::testing {

/// Points and the threshold that suits their noise.
struct ModelProblem {
  PointMatrix points;
  double threshold = 0.0;
  int outliers = 0;  ///< that many, and the first ones
  ModelParameters truth;
};

/// Lines and planes with σ = .03 in a box of side 10; correspondences in images of about 1000 pixels with σ = .5 px,
/// for E and poses in normalised coordinates.
template <MinimalModel Model>
ModelProblem MakeModelProblem(int count, double outlier_ratio, Rng rng) {
  ModelProblem problem;
  problem.outliers = static_cast<int>(std::lround(outlier_ratio * count));
  if constexpr (std::is_same_v<Model, AbsolutePose>) {
    const AbsolutePoseScene scene = MakeAbsolutePoseScene(count, outlier_ratio, 1e-3, rng);
    problem.points = scene.points;
    problem.truth = scene.truth;
    problem.threshold = 4e-3;
    return problem;
  } else if constexpr (Model::kDimension == 6) {
    // Of one unit: of the samplers one takes the scale for known.
    const CloudScene scene = MakeCloudScene(count, outlier_ratio, 0.01, rng);
    problem.points = scene.points;
    problem.truth = scene.truth;
    problem.threshold = 0.04;
    return problem;
  } else if constexpr (Model::kDimension != 4) {
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

/// Every source over the same points, by name, made anew for each search; owns what they borrow.
class AllSamplers {
 public:
  using Make = std::function<std::unique_ptr<MinimalSampler>(std::uint64_t seed)>;

  /// threshold: what an inlier is, of clouds.
  AllSamplers(const PointMatrix& points, int set_size, const std::vector<double>& quality, double threshold = 0.0) {
    for (const auto& [kind, name] : kEnumNames<MinimalSamplerKind>) {
      MinimalSamplerOptions options;
      options.sampler = kind;
      Add(name, [=](Rng rng) { return MakeMinimalSampler(options, points, set_size, rng, quality, {}, threshold); });
    }
    Add("weighted", [=](Rng rng) { return std::make_unique<WeightedSampler>(quality, set_size, rng); });
    const int count = static_cast<int>(points.rows());
    UniformSampler uniform(count, set_size, Rng(5));
    given_ = DrawSets(uniform, set_size, 100);
    Add("given", [this](Rng) { return std::make_unique<PrecomputedSampler>(given_); });
    Rng rng(6);
    for (int copy = 0; copy < 100; ++copy)
      for (int i = 0; i < count; ++i) confidences_.push_back(static_cast<float>(rng.Normal() - quality[i]));
    for (const Selection selection : {Selection::kMaximum, Selection::kProbabilistic})
      Add(selection == Selection::kMaximum ? "confidence, maximum" : "confidence, drawn", [=, this](Rng r) {
        const bool unique = selection == Selection::kMaximum;
        return std::make_unique<ConfidenceSampler>(confidences_, count, set_size, selection, unique, 1.0, r);
      });
  }
  AllSamplers(const AllSamplers&) = delete;
  AllSamplers& operator=(const AllSamplers&) = delete;

  auto begin() const { return sources_.begin(); }
  auto end() const { return sources_.end(); }

 private:
  template <class MakeFrom>
  void Add(const char* name, const MakeFrom& make) {
    sources_.emplace_back(name, [make](std::uint64_t seed) -> std::unique_ptr<MinimalSampler> {
      return make(Rng(seed).Fork("minimal_sets"));
    });
  }

  std::vector<int> given_;
  std::vector<float> confidences_;
  std::vector<std::pair<std::string, Make>> sources_;
};

inline constexpr ScoreKind kScores[] = {ScoreKind::kInlierCount, ScoreKind::kMsac, ScoreKind::kMlesac,
                                        ScoreKind::kMagsac, ScoreKind::kSigmaMarginalisedMsac};
inline constexpr LocalOptimization kOptimizers[] = {LocalOptimization::kNone, LocalOptimization::kInnerSamples,
                                                    LocalOptimization::kReweighted, LocalOptimization::kGraphCut,
                                                    LocalOptimization::kRefinement};
inline constexpr Refit kRefits[] = {Refit::kNone, Refit::kInliers, Refit::kIterated, Refit::kMixture,
                                    Refit::kReweighted};

/// Calls function(options) for every score and optimiser; the other options run through their values on the way, from
/// another place for another `shift`.
template <class Function>
void ForEachCombination(int shift, const Function& function) {
  int i = shift;
  for (const ScoreKind score : kScores)
    for (const LocalOptimization optimizer : kOptimizers) {
      ConsensusOptions options;
      options.score = score;
      options.local_optimization = optimizer;
      options.final_score = kScores[i % std::size(kScores)];
      options.refit = kRefits[(i / 2) % 5];
      options.final_refinement = i % 2   ? FinalRefinement::kRefinement
                                 : i % 4 ? FinalRefinement::kMarginalised
                                         : FinalRefinement::kNone;
      options.stopping = i % 3 ? Stopping::kBudget : Stopping::kConfidence;
      options.refit_candidates = 1 + i % 3;
      if (optimizer != LocalOptimization::kNone) {
        options.lo_starts = 2 * (i % 4);
        options.lo_restarts = i % 2;
      }
      options.local_samples = 4;
      ++i;
      function(options);
    }
}

}  // namespace diffsac::testing
