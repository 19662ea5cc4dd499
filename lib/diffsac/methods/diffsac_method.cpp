#include "diffsac/methods/diffsac_method.h"

#include <torch/torch.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "diffsac/consensus/make_source.h"
#include "diffsac/core/status.h"
#include "diffsac/methods/diffsac_denoising.h"
#include "diffsac/methods/diffsac_sources.h"
#include "diffsac/methods/learned_row.h"

namespace diffsac {
namespace {

// Where the loop stops by itself it may go on behind the row's sets, else these are the budget.
DiffsacOptions WithBudget(DiffsacOptions options) {
  if (options.consensus.stopping == Stopping::kBudget) options.consensus.max_iterations = options.Sets();
  return options;
}

// The b-th problem's rows [κ, N] of a tensor, without padding.
void AppendRows(const torch::Tensor& all, std::int64_t b, std::int64_t length, std::vector<float>* rows) {
  const std::int64_t copies = all.size(1), points = all.size(2);
  const float* row = all.data_ptr<float>() + b * copies * points;
  for (std::int64_t k = 0; k < copies; ++k, row += points) rows->insert(rows->end(), row, row + length);
}

}  // namespace

DiffsacMethod::DiffsacMethod(std::shared_ptr<const DiffsacNetwork> network, const DiffsacOptions& options, int threads)
    : LearnedMethod(network, WithBudget(options), threads),
      network_(std::move(network)),
      options_(options),
      sampler_(MakeReverseSampler(options_.sampler, network_->schedule)) {
  CheckOptions(options_);
  CheckServes(options_, *network_);
}

void DiffsacMethod::Infer(const PointBatch& batch, std::span<const std::uint64_t> seeds,
                          std::span<Prediction> predictions) const {
  auto context = network_->denoiser->Encode(batch);
  if (context.inlier_logits.defined()) SplitWeights(context.inlier_logits.sigmoid(), batch.lengths, predictions);
  if (options_.guide == SetGuide::kInlierHead) return;
  const DenoisingOptions denoising{options_.copies, options_.max_decoded_points, options_.UsesEarlierSteps()};
  auto denoised = Denoise(*network_, *sampler_, denoising, batch, seeds, std::move(context));
  std::reverse(denoised.steps.begin(), denoised.steps.end());
  for (std::size_t b = 0; b < predictions.size(); ++b) {
    const auto problem = static_cast<std::int64_t>(b);
    AppendRows(denoised.final, problem, batch.lengths[b], &predictions[b].confidences);
    for (const auto& step : denoised.steps) AppendRows(step, problem, batch.lengths[b], &predictions[b].confidences);
  }
}

std::unique_ptr<HypothesisSource> DiffsacMethod::Copies(const Guidance& guide) const {
  std::vector<float> confidences = guide.prediction.confidences;
  const bool top = options_.selection == SetSelection::kMaximum;
  if (!top)
    ScaleConfidences(confidences, options_.copies, options_.temperature, options_.selection == SetSelection::kGumbel);
  return std::make_unique<CopiesSource>(std::move(confidences), static_cast<int>(guide.space.points().rows()),
                                        guide.set_size, top ? Selection::kMaximum : Selection::kProbabilistic,
                                        options_.unique_sets, guide.rng.Fork("selection"));
}

std::unique_ptr<HypothesisSource> DiffsacMethod::Head(const Guidance& guide, const char* stream) const {
  const Eigen::VectorXf weights =
      InlierPriors(guide.space.problem(), guide.prediction.weights, options_.draws_by).cast<float>();
  return std::make_unique<TemperedSource>(std::span(weights.data(), static_cast<std::size_t>(weights.size())),
                                          guide.set_size, options_.temperature, guide.rng.Fork(stream));
}

std::unique_ptr<HypothesisSource> DiffsacMethod::Extra(const Guidance& guide) const {
  Eigen::VectorXd quality = guide.space.problem().quality;
  if (quality.size() > 0 && options_.draws_by == PriorSource::kBoth)
    quality = 1.0 - InlierPriors(guide.space.problem(), guide.prediction.weights, options_.draws_by).array();
  const bool by_quality = options_.extra_source == SourceKind::kProsac && quality.size() == guide.space.points().rows();
  SourceOptions extra;
  extra.source = by_quality ? SourceKind::kProsac : SourceKind::kUniform;
  return MakeHypothesisSource(extra, guide.space.points(), guide.set_size, guide.rng.Fork("extra_sets"),
                              {quality.data(), static_cast<std::size_t>(quality.size())});
}

std::unique_ptr<HypothesisSource> DiffsacMethod::MakeSource(const Guidance& guide) const {
  struct Part {
    std::unique_ptr<HypothesisSource> source;
    int sets;
  };
  std::vector<Part> parts;
  if (options_.guide == SetGuide::kInlierHead) {
    parts.push_back({Head(guide, "selection"), options_.copies});
  } else {
    parts.push_back({Copies(guide), options_.copies});
    if (options_.head_sets > 0) parts.push_back({Head(guide, "head_sets"), options_.head_sets});
  }
  if (options_.extra_sets > 0) parts.push_back({Extra(guide), options_.extra_sets});
  auto sequence = std::make_unique<SequenceSource>();
  for (auto& part : parts)
    sequence->Add(std::move(part.source), &part == &parts.back() ? SequenceSource::kAll : part.sets);
  return sequence;
}

std::optional<ConfidenceSteps> DiffsacMethod::Trace(const Problem& problem, std::uint64_t seed) const {
  const SolverSpace space(problem);
  if (options_.guide != SetGuide::kDiffusion || Check(space) != Status::kOk) return std::nullopt;
  const c10::InferenceMode inference;
  const auto features = ComputeFeatures({&space, 1}, {&seed, 1});
  const FeatureSet* row = features.data();
  const auto batch = MakePointBatch({&row, 1}).To(network_->device);
  const DenoisingOptions denoising{options_.copies, options_.max_decoded_points, true};
  auto denoised = Denoise(*network_, *sampler_, denoising, batch, {&seed, 1}, network_->denoiser->Encode(batch));
  ConfidenceSteps steps;
  steps.copies = options_.copies;
  steps.timesteps = std::move(denoised.times);
  for (const auto& step : denoised.steps) AppendRows(step, 0, batch.lengths[0], &steps.confidences.emplace_back());
  return steps;
}

namespace {

const RegisteredLearnedMethod<DiffsacMethod, DiffsacOptions, DiffsacNetwork> kDiffsac(
    "diffsac", "Minimal sets guided by confidences that a diffusion process draws.", DiffsacOptions(), LoadNetwork);

}  // namespace

}  // namespace diffsac
