// SampleConsensus of all models, against what its header promises for any input.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>

#include "diffsac/consensus/noise_scales.h"
#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/consensus/weighted_source.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "fuzz/fuzz_problem.h"

namespace diffsac {
namespace {

using testing::ByteReader;
using testing::FuzzProblem;

void Require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "estimate_fuzz: broken promise: %s\n", what);
  std::abort();
}

template <MinimalModel Model>
ConsensusResult Estimate(const FuzzProblem& problem, const ConsensusOptions& options, int threads) {
  const Rng rng(problem.seed), sets_rng = rng.Fork("minimal_sets");
  std::unique_ptr<HypothesisSource> source;
  if (problem.use_given_sets) {
    source = std::make_unique<GivenSource>(problem.minimal_sets);
  } else if (problem.use_weights) {
    source = std::make_unique<WeightedSource>(problem.quality, Model::kMinimalSize, sets_rng);
  } else {
    source = MakeHypothesisSource(problem.source, problem.points, Model::kMinimalSize, sets_rng, problem.quality);
  }
  return SampleConsensus<Model>(problem.points, problem.threshold, *source, options, rng, problem.hints, threads);
}

template <MinimalModel Model>
void CheckStatus(const FuzzProblem& problem, const ConsensusResult& result) {
  const Status of_points = CheckPoints<Model>(problem.points);
  if (problem.points.rows() < Model::kMinimalSize) {
    Require(of_points == Status::kTooFewPoints, "fewer points than a minimal set have that status");
  } else if (!problem.points.allFinite()) {
    Require(of_points == Status::kDegenerate, "points that are not finite are degenerate");
  }
  if (of_points != Status::kOk) {
    Require(result.status == of_points, "unfit points give their own status");
  } else if (!(problem.threshold >= kLeastScale && problem.threshold <= kLargestScale)) {
    Require(result.status == Status::kNoModel, "an unfit threshold gives no model");
  } else {
    Require(result.status == Status::kOk || result.status == Status::kNoModel, "fit points give ok or no model");
  }
}

template <MinimalModel Model>
void CheckResult(const FuzzProblem& problem, const ConsensusResult& result) {
  CheckStatus<Model>(problem, result);
  Require(result.hypotheses >= 0 && result.iterations >= 0 && result.unique_minimal_sets <= result.iterations,
          "the counts fit each other");
  Require(result.iterations <= problem.options.max_iterations, "the budget is not exceeded");
  if (result.status != Status::kOk) {
    Require(result.model.size() == 0 && result.inliers.empty() && result.score == 0.0, "a failure has no model");
    return;
  }
  using Parameters = typename Model::Parameters;
  Require(result.model.size() == Parameters::SizeAtCompileTime && result.model.allFinite(), "the model is finite");
  Require(std::isfinite(result.score), "the score is finite");
  const Parameters model = result.model;
  Require(static_cast<Eigen::Index>(result.inliers.size()) == problem.points.rows(), "the mask has the points' length");
  int support = 0;
  for (Eigen::Index i = 0; i < problem.points.rows(); ++i) {
    const double residual = Model::Residual(model, problem.points.data() + i * problem.points.cols());
    Require(result.inliers[i] == (residual <= problem.threshold ? 1 : 0), "the mask is the residuals'");
    support += result.inliers[i];
  }
  Require(support >= Model::kMinimalSize, "a model has at least a minimal set's support");
}

void CheckSame(const ConsensusResult& a, const ConsensusResult& b) {
  Require(a.status == b.status && a.model.size() == b.model.size() && a.model == b.model && a.inliers == b.inliers &&
              a.score == b.score && a.hypotheses == b.hypotheses && a.iterations == b.iterations && a.stop == b.stop &&
              a.unique_minimal_sets == b.unique_minimal_sets && a.rejected_early == b.rejected_early,
          "threads and blocks change nothing");
}

template <MinimalModel Model>
void Run(ByteReader* reader) {
  FuzzProblem problem =
      testing::ReadProblem(reader, Model::kDimension, Model::kMinimalSize, Model::Parameters::SizeAtCompileTime);
  const ConsensusResult result = Estimate<Model>(problem, problem.options, 1);
  CheckResult<Model>(problem, result);
  if (problem.threads == 1) return;
  ConsensusOptions other = problem.options;
  other.block_size = problem.other_block;
  CheckSame(result, Estimate<Model>(problem, other, problem.threads));
}

void RunOne(ByteReader* reader) {
  switch (reader->Below(8)) {
    case 0:
      return Run<Line>(reader);
    case 1:
      return Run<Plane>(reader);
    case 2:
    case 3:
      return Run<Homography>(reader);
    case 4:
    case 5:
      return Run<Fundamental>(reader);
    case 6:
      return Run<Fundamental8>(reader);
    default:
      return Run<Essential>(reader);
  }
}

}  // namespace
}  // namespace diffsac

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  diffsac::testing::ByteReader reader(data, size);
  try {
    diffsac::RunOne(&reader);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "estimate_fuzz: broken promise: nothing is thrown (%s)\n", error.what());
    std::abort();
  }
  return 0;
}
