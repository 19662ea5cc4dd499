#include "diffsac/guidance/engine/cpu_denoiser.h"

#include <algorithm>
#include <cmath>

#include "diffsac/core/status.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
#include "diffsac/problem/residual_features.h"

namespace diffsac {
namespace {

constexpr int kWidest = 256;  // of the kernels' rows
constexpr int kRelations = 2;
constexpr float kLeastLength = 1e-6f;  // of a vector that has a direction

void MakeUnit(float* vector, int size) {
  float squares = 0.0f;
  for (int i = 0; i < size; ++i) squares += vector[i] * vector[i];
  const float inverse = 1.0f / std::max(std::sqrt(squares), kLeastLength);
  for (int i = 0; i < size; ++i) vector[i] *= inverse;
}

float Dot(const float* a, const float* b, int size) {
  float sum = 0.0f;
  for (int i = 0; i < size; ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

struct CpuDenoiser::Block {
  PackedPooledBlock packed;
};

/// Reads tensors by name and keeps them where the packed layers can point to.
struct CpuDenoiser::Reader {
  SafetensorsFile* file;
  CpuDenoiser* network;
  std::size_t tensors = 0;

  const float* Read(const std::string& name, const std::vector<std::int64_t>& shape) {
    std::size_t size = 1;
    for (const std::int64_t extent : shape) size *= static_cast<std::size_t>(extent);
    auto& values = network->weights_.emplace_back(size);
    file->Read(kAverageTensors + name, shape, values);
    network->parameters_ += static_cast<std::int64_t>(size);
    ++tensors;
    return values.data();
  }

  /// [out, in] in the file, [in, out] as the kernels go through it.
  PackedLinear Linear(const std::string& name, int in, int out) {
    const float* stored = Read(name + ".weight", {out, in});
    std::vector<float> turned(static_cast<std::size_t>(in) * out);
    for (int o = 0; o < out; ++o)
      for (int i = 0; i < in; ++i)
        turned[static_cast<std::size_t>(i) * out + o] = stored[static_cast<std::size_t>(o) * in + i];
    network->weights_.back() = std::move(turned);
    const float* weights = network->weights_.back().data();
    return {weights, Read(name + ".bias", {out})};
  }

  PackedNorm Norm(const std::string& name, int width) {
    const float* scale = Read(name + ".weight", {width});
    return {scale, Read(name + ".bias", {width})};
  }

  const float* Row(const std::string& name, int width, float* bias) {
    const float* weights = Read(name + ".weight", {1, width});
    *bias = *Read(name + ".bias", {1});
    return weights;
  }

  Block PooledBlock(const std::string& name, int width) {
    PackedPooledBlock block;
    block.norm = Norm(name + ".norm", width);
    block.attention = Read(name + ".attention.weight", {kPoolingHeads, width});
    block.attention_bias = Read(name + ".attention.bias", {kPoolingHeads});
    block.set = Linear(name + ".set", (2 + kPoolingHeads) * width, 2 * width);
    block.point = Linear(name + ".point", width, 2 * width);
    block.output = Linear(name + ".output", 2 * width, width);
    return {block};
  }
};

std::string CpuDenoiser::Missing(const NetworkOptions& options) {
  const DenoiserOptions& denoiser = options.denoiser;
  if (denoiser.kind != DenoiserKind::kPooled) return "network.denoiser.kind: " + ToString(denoiser.kind);
  if (denoiser.width % kKernelLanes != 0 || denoiser.width > kWidest)
    return "network.denoiser.width: " + std::to_string(denoiser.width) + " (multiples of 16 up to 256)";
  return "";
}

CpuDenoiser::CpuDenoiser(const NetworkOptions& options, const FeatureColumns& columns, SafetensorsFile* file,
                         const Kernels& kernels)
    : kernels_(kernels),
      width_(options.denoiser.width),
      feature_width_(columns.width),
      first_residual_(columns.first_residual),
      relation_(options.denoiser.relation) {
  Reader read{file, this};
  input_points_ = read.Linear("input_points", feature_width_, width_);
  for (int i = 0; i < options.denoiser.encoder_layers; ++i)
    encoder_.push_back(read.PooledBlock("encoder" + std::to_string(i), width_));
  ln_encoder_ = read.Norm("ln_encoder", width_);
  if (options.denoiser.inlier_head) inlier_ = read.Row("inlier_proj", width_, &inlier_bias_);
  confidence_inputs_ = 1 + (relation_ ? kRelations : 0);
  if (relation_) {
    const float* logs = read.Read("relation.log_sharpness", {kRelations});
    for (int i = 0; i < kRelations; ++i) sharpness_.push_back(std::exp(logs[i]));
  }
  input_confidence_ = read.Linear("input_confidence", confidence_inputs_, width_);
  time_hidden_ = read.Linear("time_hidden", width_, width_);
  time_output_ = read.Linear("time_output", width_, width_);
  for (int i = 0; i < options.denoiser.layers; ++i)
    decoder_.push_back(read.PooledBlock("decoder" + std::to_string(i), width_));
  ln_post_ = read.Norm("ln_post", width_);
  output_ = read.Row("output_proj", width_, &output_bias_);
  std::size_t stored = 0;
  for (const auto& [name, tensor] : file->tensors()) stored += name.starts_with(kAverageTensors) ? 1 : 0;
  if (stored != read.tensors)
    throw Error(file->path() + ": holds " + std::to_string(stored) +
                " averaged weights, its configuration's network has " + std::to_string(read.tensors));
}

CpuDenoiser::~CpuDenoiser() = default;

void CpuDenoiser::Apply(const Block& block, float* rows, int points, Workspace* work) const {
  const PackedPooledBlock& packed = block.packed;
  auto& memory = work->scratch;  // what is pooled, what comes of it
  memory.resize(std::max<std::size_t>(memory.size(), (4 + kPoolingHeads) * static_cast<std::size_t>(width_)));
  float* pooled = memory.data();
  float* set = pooled + (2 + kPoolingHeads) * width_;
  kernels_.pool(rows, points, width_, packed, pooled);
  kernels_.linear(pooled, 1, (2 + kPoolingHeads) * width_, 2 * width_, packed.set, set);
  for (int i = 0; i < 2 * width_; ++i) set[i] += packed.point.bias[i];
  kernels_.transform(rows, points, width_, packed, set);
}

void CpuDenoiser::Encode(const float* features, int points, Workspace* work) const {
  work->points = points;
  work->context.resize(static_cast<std::size_t>(points) * width_);
  kernels_.linear(features, points, feature_width_, width_, input_points_, work->context.data());
  for (const Block& block : encoder_) Apply(block, work->context.data(), points, work);
  kernels_.normalize(work->context.data(), points, width_, ln_encoder_);
  work->logits.resize(inlier_ != nullptr ? points : 0);
  if (inlier_ != nullptr)
    kernels_.project(work->context.data(), points, width_, nullptr, inlier_, inlier_bias_, work->logits.data());
  if (!relation_) return;
  const int size = (feature_width_ - first_residual_) / kColumnsPerHypothesis;
  work->agreements.resize(static_cast<std::size_t>(points) * size);
  for (int i = 0; i < points; ++i) {
    float* agreement = work->agreements.data() + static_cast<std::size_t>(i) * size;
    const float* row = features + static_cast<std::size_t>(i) * feature_width_ + first_residual_;
    for (int j = 0; j < size; ++j) agreement[j] = row[j * kColumnsPerHypothesis];
    MakeUnit(agreement, size);
  }
}

void CpuDenoiser::Keep(std::span<const int> kept, Workspace* work) const {
  const auto keep = [&](std::vector<float>* rows) {
    if (rows->empty() || work->points == 0) return;
    const std::size_t width = rows->size() / static_cast<std::size_t>(work->points);
    std::vector<float> some;
    some.reserve(kept.size() * width);
    for (const int i : kept) some.insert(some.end(), rows->begin() + i * width, rows->begin() + (i + 1) * width);
    *rows = std::move(some);
  };
  keep(&work->context);
  keep(&work->agreements);
  keep(&work->logits);
  work->points = static_cast<int>(kept.size());
}

/// PointRelation's outputs (lab/torch/point_relation.h) of one copy, behind one another in `related`.
void CpuDenoiser::AddRelations(const float* c_t, Workspace* work) const {
  const int points = work->points;
  const auto size = static_cast<int>(work->agreements.size() / static_cast<std::size_t>(points));
  work->scratch.resize(std::max(work->scratch.size(), static_cast<std::size_t>(points) * kRelations));
  const float highest = *std::max_element(c_t, c_t + points);
  std::vector<float> pooled(size);
  for (int k = 0; k < kRelations; ++k) {
    std::fill(pooled.begin(), pooled.end(), 0.0f);
    for (int i = 0; i < points; ++i) {
      const float weight = std::exp(sharpness_[k] * (c_t[i] - highest));
      const float* agreement = work->agreements.data() + static_cast<std::size_t>(i) * size;
      for (int j = 0; j < size; ++j) pooled[j] += weight * agreement[j];
    }
    float total = 0.0f;
    for (int i = 0; i < points; ++i) total += std::exp(sharpness_[k] * (c_t[i] - highest));
    for (float& value : pooled) value /= total;
    MakeUnit(pooled.data(), size);
    float* out = work->scratch.data() + static_cast<std::size_t>(k) * points;
    for (int i = 0; i < points; ++i)
      out[i] = Dot(pooled.data(), work->agreements.data() + static_cast<std::size_t>(i) * size, size);
  }
}

void CpuDenoiser::Denoise(const float* c_t, int copies, double t, Workspace* work, float* out) const {
  const int points = work->points, half = width_ / 2;
  // The embedding of t and its two layers, the biases of both inputs added.
  auto& constant = work->constant;
  constant.resize(3 * static_cast<std::size_t>(width_));
  float *embedding = constant.data() + width_, *hidden = embedding + width_;
  for (int i = 0; i < half; ++i) {
    const float frequency = std::exp(static_cast<float>(i) * static_cast<float>(-std::log(10000.0) / half));
    const float angle = static_cast<float>(t) * frequency;
    embedding[i] = std::cos(angle);
    embedding[half + i] = std::sin(angle);
  }
  kernels_.linear(embedding, 1, width_, width_, time_hidden_, hidden);
  for (int i = 0; i < width_; ++i) hidden[i] /= 1.0f + std::exp(-hidden[i]);
  kernels_.linear(hidden, 1, width_, width_, time_output_, constant.data());
  for (int i = 0; i < width_; ++i) constant[i] += input_confidence_.bias[i];

  work->rows.resize(static_cast<std::size_t>(points) * width_);
  for (int k = 0; k < copies; ++k) {
    const auto copy = static_cast<std::size_t>(k) * points;
    const float* inputs[1 + kRelations] = {c_t + copy};
    int count = 1;
    if (relation_) {
      AddRelations(c_t + copy, work);
      for (int i = 0; i < kRelations; ++i)
        inputs[count++] = work->scratch.data() + static_cast<std::size_t>(i) * points;
    }
    float* rows = work->rows.data();
    kernels_.add_inputs(work->context.data(), points, width_, constant.data(), inputs, input_confidence_.weights, count,
                        rows);
    for (const Block& block : decoder_) Apply(block, rows, points, work);
    kernels_.project(rows, points, width_, &ln_post_, output_, output_bias_, out + copy);
  }
}

}  // namespace diffsac
