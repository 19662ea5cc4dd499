#include "lab/torch/pooled_function.h"

#include <ATen/autocast_mode.h>
#include <torch/torch.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "lab/torch/parallel_parts.h"
#include "lab/torch/pooled_kernels.h"

namespace diffsac {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

// Rows that pass through a block together, so that they stay in the second cache; whole sets, at least one.
constexpr std::int64_t kRowsTogether = 2048;
// Parts of a batch whose gradients of the weights are summed apart, then in order: the sums do not depend on how many
// threads there are.
constexpr int kParts = 8;

enum Weight { kGain, kShift, kAttention, kAttentionBias, kSet, kSetBias, kPoint, kPointBias, kOutput, kOutputBias };
constexpr int kWeights = 10;

float* Floats(const Tensor& tensor) { return tensor.data_ptr<float>(); }

// What forward and backward share: shapes, and how the sets are divided.
struct Shape {
  std::int64_t sets, points, width;

  explicit Shape(const Tensor& x) : sets(x.size(0)), points(x.size(1)), width(x.size(2)) {}

  // Calls use(part, first set, number of sets) for a few sets at a time; parts run in parallel.
  template <class Use>
  void ForEach(const Use& use) const {
    const std::int64_t together = std::max<std::int64_t>(1, kRowsTogether / std::max<std::int64_t>(points, 1));
    ParallelParts(kParts, [&](int part) {
      const at::NoGradGuard no_grad;
      const std::int64_t last = (part + 1) * sets / kParts;
      for (std::int64_t first = part * sets / kParts; first < last; first += together)
        use(part, first, std::min(together, last - first));
    });
  }
  Tensor Rows(const Tensor& all, std::int64_t first, std::int64_t count) const {
    return all.narrow(0, first * points, count * points);
  }
  PooledSet Set(const bool* mask, std::int64_t set) const {
    return {points, width, mask != nullptr ? mask + set * points : nullptr};
  }
};

// What a forward pass leaves for the gradient, a row a point or a set.
struct Kept {
  Tensor mean, inverse, activated, slope, shares, pooled;

  Kept(const Shape& s, const torch::TensorOptions& options)
      : mean(torch::empty({s.sets * s.points}, options)),
        inverse(torch::empty({s.sets * s.points}, options)),
        activated(torch::empty({s.sets * s.points, 2 * s.width}, options)),
        slope(torch::empty_like(activated)),
        shares(torch::empty({s.sets * s.points, kPoolingHeads}, options)),
        pooled(torch::empty({s.sets, (2 + kPoolingHeads) * s.width}, options)) {}
  explicit Kept(const variable_list& saved)
      : mean(saved[0]), inverse(saved[1]), activated(saved[2]), slope(saved[3]), shares(saved[4]), pooled(saved[5]) {}
  variable_list List() const { return {mean, inverse, activated, slope, shares, pooled}; }
};

void ForwardSets(const Shape& s, const Tensor& x, const bool* mask, const std::vector<Tensor>& w, const Kept& kept,
                 std::int64_t first, std::int64_t count, const Tensor& y) {
  const std::int64_t row = first * s.points, rows = count * s.points, width = s.width;
  const float* in = Floats(x) + row * width;
  float *mean = Floats(kept.mean) + row, *inverse = Floats(kept.inverse) + row;
  auto u = torch::empty({rows, width}, x.options());
  const auto activated = s.Rows(kept.activated, first, count), slope = s.Rows(kept.slope, first, count);
  MomentsOfRows(in, rows, width, mean, inverse);
  NormalizeRows(in, mean, inverse, Floats(w[kGain]), Floats(w[kShift]), rows, width, Floats(u));
  auto pooled = kept.pooled.narrow(0, first, count);
  for (std::int64_t k = 0; k < count; ++k)
    PoolSet(s.Set(mask, first + k), Floats(u) + k * s.points * width, Floats(w[kAttention]), Floats(w[kAttentionBias]),
            Floats(kept.shares) + (row + k * s.points) * kPoolingHeads, Floats(pooled) + k * pooled.size(1));
  const auto of_set = torch::addmm(w[kSetBias] + w[kPointBias], pooled, w[kSet].t());
  const auto hidden = u.mm(w[kPoint].t());
  for (std::int64_t k = 0; k < count; ++k) {
    const std::int64_t at = k * s.points * 2 * width;
    AddAndActivate(Floats(of_set) + k * 2 * width, Floats(hidden) + at, s.points, 2 * width, Floats(activated) + at,
                   Floats(slope) + at);
  }
  auto out = s.Rows(y, first, count);
  AddRow(in, Floats(w[kOutputBias]), rows, width, Floats(out));
  out.addmm_(activated, w[kOutput].t());
}

// The gradients of all weights in one row of numbers.
class WeightSums {
 public:
  WeightSums(const std::vector<Tensor>& weights, const torch::Tensor& row) : row_(row) {
    std::int64_t at = 0;
    for (const auto& weight : weights) {
      sizes_.push_back(weight.sizes().vec());
      starts_.push_back(at);
      at += weight.numel();
    }
  }
  static std::int64_t Count(const std::vector<Tensor>& weights) {
    std::int64_t count = 0;
    for (const auto& weight : weights) count += weight.numel();
    return count;
  }
  float* Data(Weight weight) const { return Floats(row_) + starts_[weight]; }
  Tensor At(int weight) const {
    return row_.narrow(0, starts_[weight], c10::multiply_integers(sizes_[weight])).view(sizes_[weight]);
  }

 private:
  Tensor row_;
  std::vector<std::vector<std::int64_t>> sizes_;
  std::vector<std::int64_t> starts_;
};

void BackwardSets(const Shape& s, const Tensor& x, const bool* mask, const std::vector<Tensor>& w, const Kept& kept,
                  const Tensor& dy, std::int64_t first, std::int64_t count, const Tensor& dx, const WeightSums& dw) {
  const std::int64_t row = first * s.points, rows = count * s.points, width = s.width;
  const float *in = Floats(x) + row * width, *mean = Floats(kept.mean) + row, *inverse = Floats(kept.inverse) + row;
  const auto u = torch::empty({rows, width}, x.options());
  const auto activated = s.Rows(kept.activated, first, count), slope = s.Rows(kept.slope, first, count);
  const auto dout = s.Rows(dy, first, count);
  NormalizeRows(in, mean, inverse, Floats(w[kGain]), Floats(w[kShift]), rows, width, Floats(u));
  AddSumOfRows(Floats(dout), rows, width, dw.Data(kOutputBias));
  dw.At(kOutput).addmm_(dout.t(), activated);
  const auto dhidden = dout.mm(w[kOutput]);
  auto of_set = torch::empty({count, 2 * width}, x.options());
  for (std::int64_t k = 0; k < count; ++k)
    MultiplyAndSum(Floats(slope) + k * s.points * 2 * width, s.points, 2 * width,
                   Floats(dhidden) + k * s.points * 2 * width, Floats(of_set) + k * 2 * width);
  AddSumOfRows(Floats(of_set), count, 2 * width, dw.Data(kSetBias));
  dw.At(kPoint).addmm_(dhidden.t(), u);
  const auto pooled = kept.pooled.narrow(0, first, count), dpooled = of_set.mm(w[kSet]);
  dw.At(kSet).addmm_(of_set.t(), pooled);
  auto du = dhidden.mm(w[kPoint]);
  for (std::int64_t k = 0; k < count; ++k)
    AddPoolGradients(s.Set(mask, first + k), Floats(u) + k * s.points * width, Floats(w[kAttention]),
                     Floats(kept.shares) + (row + k * s.points) * kPoolingHeads, Floats(pooled) + k * pooled.size(1),
                     Floats(dpooled) + k * pooled.size(1), Floats(du) + k * s.points * width, dw.Data(kAttention),
                     dw.Data(kAttentionBias));
  auto into = s.Rows(dx, first, count);
  into.copy_(dout);
  AddNormGradients(Floats(du), in, mean, inverse, Floats(w[kGain]), rows, width, Floats(into), dw.Data(kGain),
                   dw.Data(kShift));
}

class PooledFunction : public torch::autograd::Function<PooledFunction> {
 public:
  static Tensor forward(AutogradContext* context, const Tensor& x, const std::optional<Tensor>& mask,
                        at::TensorList list) {
    const Shape s(x);
    const variable_list weights = list.vec();
    const auto rows = x.contiguous().view({s.sets * s.points, s.width});
    const auto real = mask ? mask->contiguous() : Tensor();
    const Kept kept(s, x.options().requires_grad(false));
    const auto y = torch::empty_like(rows);
    const bool* flags = real.defined() ? real.data_ptr<bool>() : nullptr;
    s.ForEach([&](std::int64_t, std::int64_t first, std::int64_t count) {
      ForwardSets(s, rows, flags, weights, kept, first, count, y);
    });
    variable_list saved = kept.List();
    saved.push_back(rows);
    saved.push_back(real);
    saved.insert(saved.end(), weights.begin(), weights.end());
    context->save_for_backward(saved);
    return y.view_as(x);
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const variable_list saved = context->get_saved_variables();
    const Kept kept(saved);
    const Tensor &x = saved[6], &real = saved[7];
    const variable_list weights(saved.begin() + 8, saved.end());
    const auto dy = gradients[0].contiguous();
    const Shape s(dy);
    const auto rows = dy.view({s.sets * s.points, s.width}), dx = torch::empty_like(rows);
    const bool* flags = real.defined() ? real.data_ptr<bool>() : nullptr;
    const auto sums = torch::zeros({kParts, WeightSums::Count(weights)}, x.options());
    s.ForEach([&](std::int64_t part, std::int64_t first, std::int64_t count) {
      BackwardSets(s, x, flags, weights, kept, rows, first, count, dx, WeightSums(weights, sums[part]));
    });
    const WeightSums all(weights, sums.sum(0));
    variable_list result = {dx.view_as(dy), Tensor()};
    // Both biases are added to the same hidden values.
    for (int k = 0; k < kWeights; ++k) result.push_back(all.At(k == kPointBias ? kSetBias : k));
    return result;
  }
};

}  // namespace

bool HasPooledForward(const Tensor& x) {
  return x.is_cpu() && x.scalar_type() == torch::kFloat32 && x.size(2) % 8 == 0 && x.numel() > 0 &&
         torch::GradMode::is_enabled() && !at::autocast::is_autocast_enabled(at::kCPU);
}

Tensor PooledForward(const Tensor& x, const Tensor& mask, const PooledWeights& w) {
  const variable_list weights = {w.gain,     w.shift, w.attention,  w.attention_bias, w.set,
                                 w.set_bias, w.point, w.point_bias, w.output,         w.output_bias};
  return PooledFunction::apply(x, mask.defined() ? std::optional(mask) : std::nullopt, at::TensorList(weights));
}

}  // namespace diffsac
