// SampleConsensus, FindInstances and EstimateDgsac of all models, against what their headers promise for any input.

#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>

#include "diffsac/geometry/absolute_pose.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/hyperplane.h"
#include "diffsac/ransac/sample_consensus.h"
#include "diffsac/ransac/samplers/confidence_sampler.h"
#include "diffsac/ransac/samplers/weighted_sampler.h"
#include "diffsac/ransac/scores/noise_scales.h"
#include "fuzz/fuzz_problem.h"
#include "fuzz/fuzz_target.h"

namespace diffsac {
namespace {

using testing::ByteReader;
using testing::FuzzProblem;
using testing::Require;
using testing::SetsFrom;

template <class Values>
std::vector<typename Values::value_type> Rows(const Values& values, const std::vector<int>& rows) {
  std::vector<typename Values::value_type> some;
  for (const int row : rows) some.push_back(values[static_cast<std::size_t>(row)]);
  return some;
}

/// The source of sets among some of the points, all of which its weights and confidences know.
std::unique_ptr<MinimalSampler> SourceOf(const FuzzProblem& problem, int set_size, const std::vector<int>& rows,
                                         int search) {
  const Rng rng = Rng(problem.seed).Fork("minimal_sets", static_cast<std::uint64_t>(search));
  const bool all = static_cast<Eigen::Index>(rows.size()) == problem.points.rows();
  if (problem.sets_from == SetsFrom::kWeights)
    return std::make_unique<WeightedSampler>(Rows(problem.snn_ratio, rows), set_size, rng);
  if (problem.sets_from == SetsFrom::kConfidences && all)
    return std::make_unique<ConfidenceSampler>(problem.confidences, static_cast<int>(rows.size()), set_size,
                                               problem.likeliest_sets ? Selection::kMaximum : Selection::kProbabilistic,
                                               problem.unique_sets, problem.temperature, rng);
  if (problem.sets_from == SetsFrom::kGiven && all) return std::make_unique<PrecomputedSampler>(problem.minimal_sets);
  return MakeMinimalSampler(problem.source, problem.points(rows, Eigen::all), set_size, rng,
                            Rows(problem.snn_ratio, rows));
}

std::vector<int> AllRows(const FuzzProblem& problem) {
  std::vector<int> rows(static_cast<std::size_t>(problem.points.rows()));
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

template <MinimalModel Model>
ConsensusResult Estimate(const FuzzProblem& problem, const ConsensusOptions& options, int threads) {
  const auto source = SourceOf(problem, Model::kMinimalSize, AllRows(problem), 0);
  return SampleConsensus<Model>(problem.points, problem.threshold, *source, options, Rng(problem.seed), problem.priors,
                                threads);
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
    const bool within = Model::Residual(model, problem.points.data() + i * problem.points.cols()) <= problem.threshold;
    if (problem.options.threshold == ThresholdKind::kFixed)
      Require(result.inliers[i] == (within ? 1 : 0), "the mask is the residuals'");
    else
      Require(result.inliers[i] == 0 || within, "the mask holds no residual beyond the threshold");
    support += result.inliers[i];
  }
  if (problem.options.threshold == ThresholdKind::kFixed)
    Require(support >= Model::kMinimalSize, "a model has at least a minimal set's support");
}

void CheckSame(const ConsensusResult& a, const ConsensusResult& b) {
  Require(a.status == b.status && a.model.size() == b.model.size() && a.model == b.model && a.inliers == b.inliers &&
              a.score == b.score && a.hypotheses == b.hypotheses && a.iterations == b.iterations && a.stop == b.stop &&
              a.unique_minimal_sets == b.unique_minimal_sets,
          "threads and blocks change nothing");
}

template <MinimalModel Model>
void RunOneModel(const FuzzProblem& problem) {
  const ConsensusResult result = Estimate<Model>(problem, problem.options, 1);
  CheckResult<Model>(problem, result);
  if (problem.threads == 1) return;
  ConsensusOptions other = problem.options;
  other.block_size = problem.other_block;
  CheckSame(result, Estimate<Model>(problem, other, problem.threads));
}

template <MinimalModel Model>
void RunInstances(const FuzzProblem& problem) {
  const InstancesResult result = FindInstances<Model>(
      problem.points, problem.threshold,
      [&](const std::vector<int>& rows, int search) { return SourceOf(problem, Model::kMinimalSize, rows, search); },
      problem.options, problem.instances, Rng(problem.seed), problem.priors);
  Require((result.status == Status::kOk) == !result.models.empty(), "structures are found, or there is no model");
  if (result.status != Status::kOk) return;
  Require(static_cast<Eigen::Index>(result.assignment.size()) == problem.points.rows(),
          "there is a label for each point");
  Require(static_cast<int>(result.models.size()) <= problem.instances.most, "no more structures than are asked for");
  for (const ModelParameters& model : result.models) Require(model.allFinite(), "structures are finite");
  for (std::size_t i = 0; i < result.assignment.size(); ++i) {
    const std::int32_t label = result.assignment[i];
    Require(label >= 0 && label <= static_cast<int>(result.models.size()), "a label is that of a structure");
    if (label == 0) continue;
    const typename Model::Parameters model = result.models[static_cast<std::size_t>(label - 1)];
    const double* point = problem.points.data() + static_cast<Eigen::Index>(i) * problem.points.cols();
    const bool energy = problem.instances.search == InstanceSearch::kPearl;
    const double farthest = problem.threshold * (energy ? problem.instances.reach : 1.0);
    Require(Model::Residual(model, point) <= farthest, "a structure's points are within the threshold, or its reach");
  }
}

template <MinimalModel Model>
void RunDgsac(const FuzzProblem& problem) {
  const DgsacResult result = EstimateDgsac<Model>(problem.points, problem.dgsac, Rng(problem.seed));
  Require(static_cast<int>(result.sets.size()) <= problem.dgsac.max_iterations * Model::kMinimalSize,
          "no more sets than are asked for");
  if (result.status != Status::kOk) return;
  Require(result.model.allFinite(), "the model is finite");
  Require(static_cast<Eigen::Index>(result.inliers.size()) == problem.points.rows(), "the mask has the points' length");
}

template <MinimalModel Model>
void Run(ByteReader* reader) {
  const int what = reader->Below(8);
  const FuzzProblem problem =
      testing::ReadProblem(reader, Model::kDimension, Model::kMinimalSize, Model::Parameters::SizeAtCompileTime);
  if (what == 0) return RunDgsac<Model>(problem);
  if (what <= 2) return RunInstances<Model>(problem);
  RunOneModel<Model>(problem);
}

void RunOne(ByteReader* reader) {
  switch (reader->Below(9)) {
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
    case 7:
      return Run<AbsolutePose>(reader);
    default:
      return Run<Essential>(reader);
  }
}

// Any bytes are a problem; those of some length are one with points.
std::vector<std::string> Seeds() {
  std::vector<std::string> seeds;
  for (std::uint64_t i = 0; i < 32; ++i) {
    Rng rng = Rng(i).Fork("seed");
    std::string& seed = seeds.emplace_back(512 + 64 * i, '\0');
    for (char& byte : seed) byte = static_cast<char>(rng.Below(256));
  }
  return seeds;
}

const testing::AddTarget kEstimate{"estimate", Seeds, [](const std::string& bytes) {
                                     ByteReader reader(bytes);
                                     try {
                                       RunOne(&reader);
                                     } catch (const std::exception& error) {
                                       Require(false, std::string("nothing is thrown: ") + error.what());
                                     }
                                   }};

}  // namespace
}  // namespace diffsac
