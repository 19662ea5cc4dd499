#include "lab/data/dominant_plane.h"

#include <algorithm>
#include <vector>

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/consensus/samplers/minimal_sampler.h"
#include "diffsac/geometry/homography.h"
#include "lab/truth/pair_truth.h"

namespace diffsac {
namespace {

constexpr int kDraws = 500, kFewest = 16;

ConsensusOptions Options() {
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMsac;
  options.local_optimization = LocalOptimization::kInnerSamples;
  options.max_iterations = kDraws;
  options.refit = Refit::kIterated;
  options.refit_rounds = 5;
  options.final_refinement = FinalRefinement::kRefinement;
  return options;
}

}  // namespace

std::optional<Matrix3Parameters> FitDominantPlane(const PointMatrix& points, double threshold_px, int fewest,
                                                  const Rng& rng) {
  UniformSampler source(static_cast<int>(points.rows()), Homography::kMinimalSize, rng.Fork("minimal_sets"));
  const ConsensusResult result = SampleConsensus<Homography>(points, threshold_px, source, Options(), rng);
  if (result.status != Status::kOk || std::count(result.inliers.begin(), result.inliers.end(), 1) < fewest) return {};
  return Matrix3Parameters(result.model);
}

std::optional<Eigen::Matrix3d> DominantHomography(const Problem& problem, const GroundTruth& truth, double threshold_px,
                                                  const std::string& id) {
  if (!truth.fundamental || truth.homography) return truth.homography;
  const Eigen::VectorXd distances = TruthDistances(problem, truth);
  std::vector<int> rows;
  for (int i = 0; i < distances.size(); ++i)
    if (distances[i] <= threshold_px && problem.points.row(i).allFinite()) rows.push_back(i);
  if (static_cast<int>(rows.size()) < kFewest) return {};
  const PointMatrix points = problem.points(rows, Eigen::all);
  const auto model = FitDominantPlane(points, threshold_px, kFewest, Rng(0).Fork("dominant_plane/" + id));
  return model ? std::optional(AsMatrix(*model)) : std::nullopt;
}

}  // namespace diffsac
