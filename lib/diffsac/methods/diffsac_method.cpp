#include "diffsac/methods/diffsac_method.h"

#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "diffsac/consensus/hypothesis_source.h"
#include "diffsac/consensus/make_source.h"
#include "diffsac/core/parallel.h"
#include "diffsac/methods/network_batch.h"

namespace diffsac {
namespace {

// Keeps the logarithm of a probability finite.
constexpr float kLeastProbability = 1e-12f;

// Standard normal noise [B, κ, N]; a problem's noise depends on its own seed, never on its batch mates or padding.
torch::Tensor DrawNoise(std::span<const std::uint64_t> seeds, const std::vector<std::int64_t>& lengths,
                        std::int64_t copies, std::int64_t points, const char* name, int step) {
  auto noise = torch::zeros({static_cast<std::int64_t>(seeds.size()), copies, points});
  float* out = noise.data_ptr<float>();
  for (std::size_t b = 0; b < seeds.size(); ++b) {
    Rng rng = Rng(seeds[b]).Fork(name, static_cast<std::uint64_t>(step));
    for (std::int64_t k = 0; k < copies; ++k) {
      float* row = out + (static_cast<std::int64_t>(b) * copies + k) * points;
      for (std::int64_t i = 0; i < lengths[b]; ++i) row[i] = static_cast<float>(rng.Normal());
    }
  }
  return noise;
}

// Keeps the `count` points of highest inlier logit. Returns their indices [B, count].
torch::Tensor KeepLikelyPoints(Context& context, std::int64_t count) {
  auto logits = context.inlier_logits;
  if (context.mask.defined()) logits = logits.masked_fill(context.mask.logical_not(), -1e9);
  const auto kept = std::get<1>(logits.topk(count, -1));
  context.points = context.points.gather(1, kept.unsqueeze(-1).expand({-1, -1, context.points.size(2)}));
  if (context.mask.defined()) context.mask = context.mask.gather(1, kept);
  return kept;
}

PointFeatures FeaturesOf(const DiffsacNetwork& network, int preference_draws) {
  auto options = network.options.features;
  if (preference_draws > 0) options.preference_draws = preference_draws;
  return PointFeatures(options, network.task);
}

}  // namespace

void DiffsacOptions::Bind(OptionsBinder& b) {
  b.Field("copies", copies, Within(1, 10000));
  b.Group("sampler", sampler);
  b.Choice("selection", selection, {"maximum", "probabilistic", "gumbel"});
  b.Field("temperature", temperature, Positive());
  b.Choice("guide", guide, {"diffusion", "inlier_head"});
  b.Field("head_sets", head_sets, Within(0, 10000));
  b.Field("extra_sets", extra_sets, Within(0, 1000000));
  b.Choice("extra_source", extra_source, {"uniform", "prosac"});
  b.Field("fundamental_points", fundamental_points, Within(7, 8));
  b.Field("unique_sets", unique_sets);
  b.Field("intermediate_sets", intermediate_sets);
  b.Field("feature_hypotheses", feature_hypotheses);
  b.Field("learned_refit", learned_refit);
  b.Field("max_decoded_points", max_decoded_points, AtLeast(0));
  b.Field("preference_draws", preference_draws, AtLeast(0));
  b.Field("batch", batch, Within(1, 4096));
  b.Group("consensus", consensus);
}

DiffsacMethod::DiffsacMethod(std::shared_ptr<const DiffsacNetwork> network, DiffsacOptions options, int threads)
    : network_(std::move(network)),
      options_(std::move(options)),
      threads_(threads),
      features_(FeaturesOf(*network_, options_.preference_draws)),
      sampler_(MakeReverseSampler(options_.sampler, network_->schedule)) {
  const bool head = network_->options.denoiser.inlier_head;
  if (options_.learned_refit && !head)
    throw Error("inference.learned_refit: the network has no inlier head (network.denoiser.inlier_head is false)");
  if (options_.guide == "inlier_head" && !head)
    throw Error("inference.guide: the network has no inlier head (network.denoiser.inlier_head is false)");
  if (options_.head_sets > 0 && !head)
    throw Error("inference.head_sets: the network has no inlier head (network.denoiser.inlier_head is false)");
  if (options_.max_decoded_points > 0 && !head)
    throw Error("inference.max_decoded_points: the network has no inlier head (network.denoiser.inlier_head is false)");
}

diffsac::Estimate DiffsacMethod::Estimate(const Problem& problem, std::uint64_t seed) const {
  return EstimateBatch({&problem, 1}, {&seed, 1})[0];
}

std::vector<DiffsacMethod::Prediction> DiffsacMethod::Predict(std::span<const Problem* const> problems,
                                                              std::span<const std::uint64_t> seeds, double* ms_features,
                                                              double* ms_denoise, ConfidenceSteps* steps) const {
  const c10::InferenceMode inference;
  const auto start = MethodClock::now();
  const std::int64_t count = static_cast<std::int64_t>(problems.size()), copies = options_.copies;
  std::vector<Prediction> predictions(problems.size());
  ParallelFor(count, threads_, [&](std::int64_t b) {
    predictions[b].features = features_.Compute(*problems[b], Rng(seeds[b]).Fork("features"));
  });
  *ms_features = MillisecondsSince(start);

  const auto network_start = MethodClock::now();
  std::vector<const FeatureSet*> sets;
  for (const auto& prediction : predictions) sets.push_back(&prediction.features);
  const auto batch = MakePointBatch(sets);
  const auto& device = network_->device;
  auto context = network_->denoiser->Encode(batch.To(device));
  torch::Tensor probability;
  if (context.inlier_logits.defined()) probability = context.inlier_logits.sigmoid().to(torch::kCPU).contiguous();

  const std::int64_t points = batch.max_points();
  for (std::int64_t b = 0; b < count && probability.defined(); ++b) {
    const float* values = probability.data_ptr<float>() + b * points;
    predictions[b].inlier_probability.assign(values, values + batch.lengths[b]);
  }
  if (options_.guide == "inlier_head" && steps == nullptr) {
    *ms_denoise = MillisecondsSince(network_start);
    return predictions;
  }
  torch::Tensor kept;
  const std::int64_t limit = options_.max_decoded_points;
  if (limit > 0 && limit < points && limit >= SetSize()) kept = KeepLikelyPoints(context, limit);
  const auto select = [&](const torch::Tensor& full) {
    return kept.defined() ? full.to(device).gather(2, kept.unsqueeze(1).expand({-1, copies, -1})) : full.to(device);
  };
  const bool self_conditioning = network_->options.denoiser.self_conditioning;
  torch::Tensor previous;
  const auto denoise = [&](const torch::Tensor& c_t, double t) {
    const auto time = torch::full({1, 1}, t, c_t.options());
    auto confidence = network_->Confidence(network_->denoiser->Denoise(context, c_t, time, previous));
    if (self_conditioning) previous = confidence;
    return confidence;
  };
  const auto noise = [&](int step) {
    return select(DrawNoise(seeds, batch.lengths, copies, points, "step_noise", step));
  };
  std::vector<torch::Tensor> rows;
  const auto observe = [&](int, double t, const torch::Tensor&, const torch::Tensor& prediction) {
    if (!options_.intermediate_sets && steps == nullptr) return;
    rows.push_back(prediction.to(torch::kCPU));
    if (steps != nullptr) steps->timesteps.push_back(t);
  };
  const auto predict_directly = [&] {
    const double last = network_->options.schedule.steps - 1;
    const auto nothing = torch::zeros({count, 1, context.points.size(1)}, context.points.options());
    const auto prediction = denoise(nothing, last).expand({-1, copies, -1}).contiguous();
    observe(0, last, nothing, prediction);
    return prediction;
  };
  const auto sample = [&] {
    const auto c_T = select(DrawNoise(seeds, batch.lengths, copies, points, "c_T", 0));
    return sampler_->Sample(denoise, c_T, noise, observe);
  };
  auto final = (network_->options.direct ? predict_directly() : sample()).to(torch::kCPU);
  std::reverse(rows.begin(), rows.end());
  rows.insert(rows.begin(), final);

  const auto lowest = -std::numeric_limits<float>::infinity();
  const auto kept_cpu = kept.defined() ? kept.to(torch::kCPU) : kept;
  for (auto& row : rows) {
    row = row.to(torch::kFloat);
    if (kept.defined())
      row =
          torch::full({count, copies, points}, lowest).scatter(2, kept_cpu.unsqueeze(1).expand({-1, copies, -1}), row);
    row = row.contiguous();
  }
  for (std::int64_t b = 0; b < count; ++b) {
    auto& prediction = predictions[b];
    const std::int64_t length = batch.lengths[b];
    prediction.confidences.resize(rows.size() * copies * length);
    float* out = prediction.confidences.data();
    for (const auto& row : rows)
      for (std::int64_t k = 0; k < copies; ++k, out += length)
        std::memcpy(out, row.data_ptr<float>() + (b * copies + k) * points, sizeof(float) * length);
  }
  *ms_denoise = MillisecondsSince(network_start);
  return predictions;
}

std::vector<int> DiffsacMethod::SetsFrom(std::vector<float> keys, int count, int points, int set_size, Rng rng) const {
  const bool maximum = options_.selection == "maximum";
  if (options_.selection == "gumbel")
    for (float& key : keys) key = std::log(std::max(0.5f * (1.0f + key), kLeastProbability));
  const auto [first, last] = options_.temperature;
  for (int k = 0; k < count && !maximum; ++k) {
    const double share = count > 1 ? static_cast<double>(k) / (count - 1) : 0.0;
    const auto inverse = static_cast<float>(1.0 / (first * std::pow(last / first, share)));
    for (std::size_t i = 0; i < static_cast<std::size_t>(points); ++i)
      keys[static_cast<std::size_t>(k) * points + i] *= inverse;
  }
  std::vector<int> sets;
  const auto selection = maximum ? Selection::kMaximum : Selection::kProbabilistic;
  ConfidenceSource(keys, selection, options_.unique_sets, 1.0).Draw(points, set_size, count, rng, &sets);
  return sets;
}

std::vector<int> DiffsacMethod::HeadSets(const Prediction& prediction, int count, int set_size, Rng rng) const {
  std::vector<float> keys;
  for (int k = 0; k < count; ++k)
    for (const float p : prediction.inlier_probability) keys.push_back(2.0f * p - 1.0f);
  return SetsFrom(std::move(keys), count, static_cast<int>(prediction.inlier_probability.size()), set_size, rng);
}

std::vector<int> DiffsacMethod::GuidedSets(const Prediction& prediction, int points, int set_size,
                                           const Rng& rng) const {
  if (options_.guide == "inlier_head") return HeadSets(prediction, options_.copies, set_size, rng.Fork("selection"));
  // Earlier steps only fill the places of repeated sets, and drawn sets seldom repeat.
  const bool more = options_.intermediate_sets && options_.unique_sets && options_.selection == "maximum";
  const std::size_t own = static_cast<std::size_t>(options_.copies) * points;
  const auto begin = prediction.confidences.begin();
  std::vector<float> keys(begin, more ? prediction.confidences.end() : begin + static_cast<std::ptrdiff_t>(own));
  auto sets = SetsFrom(std::move(keys), options_.copies, points, set_size, rng.Fork("selection"));
  const auto head_sets = HeadSets(prediction, options_.head_sets, set_size, rng.Fork("head_sets"));
  sets.insert(sets.end(), head_sets.begin(), head_sets.end());
  return sets;
}

void DiffsacMethod::AddExtraSets(const Problem& problem, const SolverSpace& space, int set_size, const Rng& rng,
                                 std::vector<int>* sets) const {
  if (options_.extra_sets == 0) return;
  const int points = static_cast<int>(space.points().rows());
  const bool has_quality = problem.quality.size() == points;
  SourceOptions extra;
  extra.source = has_quality ? options_.extra_source : "uniform";
  const std::span<const double> quality(problem.quality.data(), has_quality ? points : 0);
  MakeHypothesisSource(extra, space.points(), set_size, quality)
      ->Draw(points, set_size, options_.extra_sets, rng.Fork("extra_sets"), sets);
}

int DiffsacMethod::SetSize() const {
  return network_->task == Task::kFundamental ? options_.fundamental_points : MinimalSetSize(network_->task);
}

std::vector<int> DiffsacMethod::MinimalSets(const Problem& problem, std::uint64_t seed) const {
  if (CheckProblem(problem) != Status::kOk) return {};
  const Problem* one = &problem;
  double ms_features = 0.0, ms_denoise = 0.0;
  const auto prediction = Predict({&one, 1}, {&seed, 1}, &ms_features, &ms_denoise, nullptr)[0];
  return GuidedSets(prediction, static_cast<int>(problem.points.rows()), SetSize(), Rng(seed));
}

template <MinimalModel Model>
ConsensusResult DiffsacMethod::Consensus(const Problem& problem, const Prediction& prediction, const Rng& rng) const {
  const SolverSpace space(problem);
  const int points = static_cast<int>(space.points().rows());
  std::vector<int> sets = GuidedSets(prediction, points, Model::kMinimalSize, rng);
  AddExtraSets(problem, space, Model::kMinimalSize, rng, &sets);
  ConsensusHints hints;
  if (options_.feature_hypotheses) hints.models = prediction.features.models;
  if (options_.learned_refit)
    hints.fit_weights = Eigen::Map<const Eigen::VectorXf>(prediction.inlier_probability.data(), points).cast<double>();
  return SampleConsensus<Model>(space.points(), space.threshold(), sets, options_.consensus, rng.Fork("consensus"),
                                hints);
}

diffsac::Estimate DiffsacMethod::EstimateFrom(const Problem& problem, const Prediction& prediction,
                                              std::uint64_t seed) const {
  const auto start = MethodClock::now();
  const Rng rng(seed);
  auto result = DispatchSetSize(problem.task, options_.fundamental_points,
                                [&]<class Model>() { return Consensus<Model>(problem, prediction, rng); });
  return EstimateOf(std::move(result), prediction.features.hypotheses, start);
}

std::vector<diffsac::Estimate> DiffsacMethod::EstimateBatch(std::span<const Problem> problems,
                                                            std::span<const std::uint64_t> seeds) const {
  const auto predict = [&](std::span<const Problem* const> good, std::span<const std::uint64_t> good_seeds,
                           double* ms_features,
                           double* ms_network) { return Predict(good, good_seeds, ms_features, ms_network, nullptr); };
  const auto finish = [&](const Problem& problem, const Prediction& prediction, std::uint64_t seed) {
    return EstimateFrom(problem, prediction, seed);
  };
  return EstimateTogether(problems, seeds, threads_, predict, finish);
}

ConfidenceSteps DiffsacMethod::Trace(const Problem& problem, std::uint64_t seed) const {
  if (const auto status = CheckProblem(problem); status != Status::kOk)
    throw Error("these points cannot be estimated from: " + std::string(ToString(status)));
  ConfidenceSteps steps;
  steps.copies = options_.copies;
  const Problem* one = &problem;
  double ms_features = 0.0, ms_denoise = 0.0;
  const auto prediction = Predict({&one, 1}, {&seed, 1}, &ms_features, &ms_denoise, &steps)[0];
  const std::size_t size = static_cast<std::size_t>(options_.copies) * problem.points.rows();
  // Rows stand final first, then latest to earliest; the trace runs forward in reverse time.
  for (std::size_t row = prediction.confidences.size() / size; row-- > 1;)
    steps.confidences.emplace_back(prediction.confidences.begin() + row * size,
                                   prediction.confidences.begin() + (row + 1) * size);
  return steps;
}

}  // namespace diffsac
