#include "diffsac/estimate/diffsac_estimator.h"

#include <algorithm>
#include <string>
#include <utility>

#include "diffsac/core/status.h"
#include "diffsac/estimate/diffsac_samplers.h"
#include "diffsac/estimate/encoded_points.h"
#include "diffsac/estimate/point_prior.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"

namespace diffsac {
namespace {

// Where the loop stops by itself it may go on behind the row's sets, else these are the budget.
DiffsacOptions WithBudget(DiffsacOptions options) {
  if (options.consensus.stopping == Stopping::kBudget) options.consensus.max_iterations = options.Sets();
  return options;
}

DenoisingOptions DenoisingOf(const DiffsacOptions& options) {
  return {options.sampler, options.num_diffusion_samples, options.max_decoded_points, options.UsesEarlierSteps()};
}

}  // namespace

DiffsacEstimator::DiffsacEstimator(std::shared_ptr<const DiffsacModel> network, const DiffsacOptions& options,
                                   int threads)
    : DiffsacEstimator(std::move(network), std::make_shared<const DiffsacOptions>(WithBudget(options)), threads) {
  options.consensus.Check();
  CheckServes(options, *network_);
}

DiffsacEstimator::DiffsacEstimator(std::shared_ptr<const DiffsacModel> network,
                                   const std::shared_ptr<const DiffsacOptions>& options, int threads)
    : LearnedEstimator(network, options, threads), network_(std::move(network)), options_(*options) {}

void DiffsacEstimator::Infer(std::span<const NormalizedProblem> spaces, std::span<const std::uint64_t> seeds,
                             std::span<Prediction> predictions) const {
  std::vector<EncodedPoints> encoded(predictions.size());
  std::vector<const FeatureSet*> chosen;
  for (std::size_t b = 0; b < predictions.size(); ++b) {
    const FeatureSet& all = predictions[b].features;
    if (options_.max_encoded_points > 0 && options_.max_encoded_points < all.values.rows())
      encoded[b].Choose(PointPrior(spaces[b], all, features()), options_.max_encoded_points, all);
    chosen.push_back(encoded[b].chosen() ? &encoded[b].features() : &all);
  }
  std::vector<Denoised> denoised = network_->Run(DenoisingOf(options_), chosen, seeds, threads());
  for (std::size_t b = 0; b < predictions.size(); ++b) {
    if (encoded[b].chosen()) encoded[b].GiveToAll(&denoised[b]);
    predictions[b].weights = std::move(denoised[b].weights);
    auto& confidences = predictions[b].confidences = std::move(denoised[b].confidences);
    for (auto step = denoised[b].steps.rbegin(); step != denoised[b].steps.rend(); ++step)
      confidences.insert(confidences.end(), step->begin(), step->end());
  }
}

std::unique_ptr<MinimalSampler> DiffsacEstimator::Copies(const Guidance& guide) const {
  std::vector<float> confidences = guide.prediction.confidences;
  const bool top = options_.selection == SetSelection::kMaximum;
  if (!top)
    ScaleConfidences(confidences, options_.num_diffusion_samples, options_.temperature,
                     options_.selection == SetSelection::kGumbel);
  return std::make_unique<CopiesSampler>(std::move(confidences), static_cast<int>(guide.space.points().rows()),
                                         guide.set_size, top ? Selection::kMaximum : Selection::kProbabilistic,
                                         options_.unique_sets, guide.rng.Fork("selection"));
}

std::unique_ptr<MinimalSampler> DiffsacEstimator::Head(const Guidance& guide, const char* stream) const {
  const Eigen::VectorXf weights = InlierPriors(guide.space, guide.prediction.weights, options_.draws_by).cast<float>();
  return std::make_unique<TemperedSampler>(std::span(weights.data(), static_cast<std::size_t>(weights.size())),
                                           guide.set_size, options_.temperature, guide.rng.Fork(stream));
}

std::unique_ptr<MinimalSampler> DiffsacEstimator::Extra(const Guidance& guide) const {
  Eigen::VectorXd quality = guide.space.problem().snn_ratio;
  if (quality.size() > 0 && options_.draws_by == PriorSource::kBoth)
    quality = 1.0 - InlierPriors(guide.space, guide.prediction.weights, options_.draws_by).array();
  const bool by_quality =
      options_.extra_sampler == MinimalSamplerKind::kProsac && quality.size() == guide.space.points().rows();
  MinimalSamplerOptions extra;
  extra.sampler = by_quality ? MinimalSamplerKind::kProsac : MinimalSamplerKind::kUniform;
  return MakeMinimalSampler(extra, guide.space.points(), guide.set_size, guide.rng.Fork("extra_sets"),
                            {quality.data(), static_cast<std::size_t>(quality.size())});
}

std::unique_ptr<MinimalSampler> DiffsacEstimator::MakeSampler(const Guidance& guide) const {
  struct Part {
    std::unique_ptr<MinimalSampler> sampler;
    int sets;
  };
  std::vector<Part> parts;
  if (options_.num_diffusion_samples > 0) parts.push_back({Copies(guide), options_.num_diffusion_samples});
  // Two names, because published tables were drawn with them.
  const char* stream = options_.num_diffusion_samples > 0 ? "head_sets" : "selection";
  if (options_.num_guided_samples > 0) parts.push_back({Head(guide, stream), options_.num_guided_samples});
  if (options_.num_uniform_samples > 0) parts.push_back({Extra(guide), options_.num_uniform_samples});
  auto sequence = std::make_unique<SequenceSampler>();
  for (auto& part : parts)
    sequence->Add(std::move(part.sampler), &part == &parts.back() ? SequenceSampler::kAll : part.sets);
  return sequence;
}

std::optional<ConfidenceSteps> DiffsacEstimator::Trace(const Problem& problem, std::uint64_t seed) const {
  const NormalizedProblem space(problem);
  if (options_.num_diffusion_samples == 0 || Check(space) != Status::kOk) return std::nullopt;
  const auto all = ComputeFeatures({&space, 1}, {&seed, 1});
  const FeatureSet* row = all.data();
  DenoisingOptions denoising = DenoisingOf(options_);
  denoising.keep_steps = true;
  Denoised denoised = std::move(network_->Run(denoising, {&row, 1}, {&seed, 1}, 1).front());
  ConfidenceSteps steps;
  steps.num_diffusion_samples = options_.num_diffusion_samples;
  steps.timesteps = std::move(denoised.times);
  steps.confidences = std::move(denoised.steps);
  return steps;
}

}  // namespace diffsac
