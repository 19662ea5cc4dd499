#include "diffsac/estimate/presets.h"

#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

constexpr int kDraws = 1000;

void StopWhenConfident(ConsensusOptions* consensus) {
  consensus->stopping = Stopping::kConfidence;
  consensus->confidence = 0.9999;
}

/// By the planes of the tuning scenes (docs/experiments.md): wider scales than Sampson distances of one dimension have,
/// and matches that count alike, the ratio being worth no more than the order of the draws.
void SuitHomographies(ConsensusOptions* consensus) {
  consensus->least_scale = 2.0;
  consensus->greatest_scale = 8.0;
  consensus->camera_prior = 0.3;
  consensus->inlier_prior_power = 0.0;
}

/// MSAC over noise scales from the least to the greatest.
ConsensusOptions OverScales(double least, double greatest) {
  ConsensusOptions consensus;
  consensus.score = consensus.final_score = ScoreKind::kSigmaMarginalisedMsac;
  consensus.least_scale = least;
  consensus.greatest_scale = greatest;
  consensus.local_optimization = LocalOptimization::kInnerSamples;
  consensus.refit = Refit::kIterated;
  consensus.refit_rounds = 5;
  consensus.refit_threshold_factor = 1.2;
  consensus.final_refinement = FinalRefinement::kMarginalised;
  StopWhenConfident(&consensus);
  // A sample of inliers alone is not yet a good model.
  consensus.min_iterations = 100;
  return consensus;
}

/// With ten refined hypotheses, for two views in pixels.
ConsensusOptions MarginalisedConsensus(Task task) {
  ConsensusOptions consensus = OverScales(task == Task::kFundamental ? 0.5 : 1.0, 4.0);
  consensus.threshold = ThresholdKind::kAdaptive;
  consensus.camera_prior = task == Task::kFundamental ? 0.3 : 0.0;
  if (FindsFocals(task)) consensus.camera_prior = 0.01;
  consensus.refit_candidates = 10;
  consensus.num_finalists = 3;
  consensus.inlier_prior_power = 1.0;
  consensus.keypoint_orientation_weight = 0.25;
  if (task == Task::kFundamental) {
    // Its landscape has many optima. Essential matrices gain nothing by it (docs/experiments.md).
    consensus.lo_starts = 10;
    consensus.lo_restarts = 5;
  }
  if (task == Task::kHomography) SuitHomographies(&consensus);
  return consensus;
}

ClassicalOptions RecommendedForPoints() {
  ClassicalOptions options;
  options.max_iterations = 420;
  ConsensusOptions& consensus = options.consensus;
  consensus.score = consensus.final_score = ScoreKind::kMlesac;
  consensus.refit = Refit::kMixture;
  consensus.refit_candidates = 5;
  consensus.sigma_prior = 30.0;
  StopWhenConfident(&consensus);
  consensus.min_iterations = 50;
  return options;
}

/// Matches of clouds, of which few are right: sets of agreeing edges.
ClassicalOptions RecommendedForClouds(Task task) {
  ClassicalOptions options;
  options.max_iterations = 10000;
  options.search_again = true;
  options.sampling.sampler =
      task == Task::kRigid ? MinimalSamplerKind::kLengthConsistency : MinimalSamplerKind::kLengthRatioConsistency;
  ConsensusOptions& consensus = options.consensus = OverScales(0.25, 1.5);
  consensus.local_samples = 3;
  consensus.refit_candidates = 5;
  consensus.num_finalists = 2;
  // Draws are few and dear.
  consensus.block_size = 64;
  return options;
}

/// By the validation images of NYU-VP (docs/several.md).
void ScoreByLength(ConsensusOptions* consensus) {
  consensus->score = consensus->final_score = ScoreKind::kMsac;
  consensus->refit = Refit::kIterated;
  consensus->refit_rounds = 3;
  consensus->refit_candidates = 10;
  consensus->final_refinement = FinalRefinement::kRefinement;
  consensus->inlier_prior_power = 1.0;
}

/// With it the lists end about where people's do, on the validation images of NYU-VP (docs/vanishing_points.md).
constexpr double kLeastChooserValue = 0.35;

}  // namespace

ClassicalOptions RecommendedClassical(Task task) {
  if (task == Task::kLine || task == Task::kPlane) return RecommendedForPoints();
  if (IsOfTwoClouds(task)) return RecommendedForClouds(task);
  ClassicalOptions options = LoRansacOptions(task);
  options.max_iterations = kDraws;
  options.sampling.sampler = MinimalSamplerKind::kProsac;
  StopWhenConfident(&options.consensus);
  options.search_again = true;
  options.photographs = true;
  if (IsTwoView(task)) options.consensus = MarginalisedConsensus(task);
  return options;
}

DiffsacOptions LearnedProsac(Task task) {
  DiffsacOptions options;
  options.search_again = true;
  options.photographs = true;
  options.num_diffusion_samples = 0;
  options.num_guided_samples = kDraws / 2;
  options.num_uniform_samples = kDraws / 2;
  options.extra_sampler = MinimalSamplerKind::kProsac;
  options.draws_by = PriorSource::kBoth;
  options.selection = SetSelection::kGumbel;
  options.temperature = {0.2, 1.0};
  // The matches that are likeliest by ratio and neighbourhood, twice as many as in training.
  options.max_encoded_points = 512;
  options.inlier_prior_of = PriorSource::kRatio;
  options.consensus = MarginalisedConsensus(task);
  if (task == Task::kEssential || task == Task::kFundamental) {
    // Their networks know matches well enough for the score to listen to them (docs/experiments.md).
    options.inlier_prior_of = PriorSource::kBoth;
    options.consensus.inlier_prior_power = 0.5;
  }
  return options;
}

ClassicalOptions SeveralInstances(Task task) {
  if (task == Task::kVanishingPoint) return VanishingPoints("models/" + ChooserFile(true));
  ClassicalOptions options = LoRansacOptions(task);
  options.max_iterations = kDraws;
  options.sampling.sampler = MinimalSamplerKind::kNapsac;
  options.consensus.refit_rounds = 3;
  options.instances.search = InstanceSearch::kAtOnce;
  return options;
}

ClassicalOptions VanishingPoints(const std::string& chooser) {
  ClassicalOptions options;
  options.sampling.sampler = MinimalSamplerKind::kWeighted;
  options.instances.most = 8;
  if (chooser.empty()) {
    options.max_iterations = kDraws;
    ScoreByLength(&options.consensus);
    options.instances.search = InstanceSearch::kAtOnce;
    return options;
  }
  options.max_iterations = 1500;
  options.instances.search = InstanceSearch::kChosen;
  options.instances.chooser = chooser;
  options.instances.least_value = kLeastChooserValue;
  return options;
}

DiffsacOptions PaperDiffsac() { return {}; }

DiffsacOptions DiffusionGuided(Task task) {
  DiffsacOptions options = PaperDiffsac();
  if (IsTwoView(task)) {
    const DiffsacOptions learned = LearnedProsac(task);
    options.inlier_prior_of = learned.inlier_prior_of;
    options.consensus = learned.consensus;
  } else {
    options.consensus = RecommendedForPoints().consensus;
  }
  // As in the networks' trainings.
  options.max_encoded_points = 512;
  options.max_decoded_points = IsTwoView(task) ? 128 : 32;
  options.consensus.stopping = Stopping::kBudget;
  return options;
}

std::string ModelFile(Task task, bool rated) {
  const bool own = !rated && (task == Task::kEssential || task == Task::kFundamental);
  return (own ? "without_ratio_" : "") + ToString(task) + "/model.safetensors";
}

std::string ChooserFile(bool calibrated) {
  return std::string("vanishing_point_chooser") + (calibrated ? "" : "_uncalibrated") + "/model.safetensors";
}

}  // namespace diffsac
