#include "diffsac/guidance/engine/kernels.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "diffsac/core/random.h"

using namespace diffsac;

namespace {

std::vector<float> Normals(std::size_t count, const char* name, double scale = 1.0) {
  Rng rng = Rng(3).Fork(name);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(scale * rng.Normal());
  return values;
}

/// A linear layer in double precision, weights [in, out].
std::vector<double> Linear(const std::vector<double>& x, int rows, int in, int out, const float* w, const float* b) {
  std::vector<double> y(static_cast<std::size_t>(rows) * out);
  for (int r = 0; r < rows; ++r)
    for (int o = 0; o < out; ++o) {
      double sum = b[o];
      for (int k = 0; k < in; ++k) sum += x[r * in + k] * w[k * out + o];
      y[r * out + o] = sum;
    }
  return y;
}

std::vector<double> Normed(const std::vector<float>& x, int rows, int width, const std::vector<float>& scale,
                           const std::vector<float>& shift) {
  std::vector<double> y(x.begin(), x.end());
  for (int r = 0; r < rows; ++r) {
    double mean = 0.0, variance = 0.0;
    for (int i = 0; i < width; ++i) mean += y[r * width + i] / width;
    for (int i = 0; i < width; ++i) variance += std::pow(y[r * width + i] - mean, 2) / width;
    for (int i = 0; i < width; ++i)
      y[r * width + i] = (y[r * width + i] - mean) / std::sqrt(variance + 1e-5) * scale[i] + shift[i];
  }
  return y;
}

double Gelu(double x) { return 0.5 * x * (1.0 + std::tanh(std::sqrt(2.0 / M_PI) * (x + 0.044715 * x * x * x))); }

void CheckClose(const float* values, const std::vector<double>& expected, double margin) {
  double worst = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) worst = std::max(worst, std::abs(values[i] - expected[i]));
  CHECK(worst <= margin);
}

/// Weights of a block of width W.
struct Block {
  int width;
  std::vector<float> scale, shift, attention, attention_bias, set, set_bias, point, point_bias, output, output_bias;
  explicit Block(int w)
      : width(w),
        scale(Normals(w, "scale")),
        shift(Normals(w, "shift")),
        attention(Normals(4 * w, "attention", 0.5)),
        attention_bias(Normals(4, "attention_bias")),
        set(Normals(12 * w * w, "set", 0.1)),
        set_bias(Normals(2 * w, "set_bias")),
        point(Normals(2 * w * w, "point", 0.2)),
        point_bias(Normals(2 * w, "point_bias")),
        output(Normals(2 * w * w, "output", 0.2)),
        output_bias(Normals(w, "output_bias")) {}
  PackedPooledBlock Packed() const {
    return {{scale.data(), shift.data()},
            attention.data(),
            attention_bias.data(),
            {set.data(), set_bias.data()},
            {point.data(), point_bias.data()},
            {output.data(), output_bias.data()}};
  }
};

template <class Check>
void WithEveryKernel(const Check& check) {
  const KernelList list = AvailableKernels();
  REQUIRE(list.count >= 1);
  for (int i = 0; i < list.count; ++i) {
    INFO(list.all[i]->name);
    check(*list.all[i]);
  }
}

}  // namespace

TEST_CASE("the best kernels are among those that this machine runs, and the plain ones always are") {
  const KernelList list = AvailableKernels();
  CHECK(&BestKernels() == list.all[0]);
  CHECK(std::string(list.all[list.count - 1]->name) == "baseline");
}

TEST_CASE("the linear kernel multiplies any number of rows and columns of any depth") {
  WithEveryKernel([](const Kernels& kernels) {
    for (const int rows : {1, 3, 4, 11, 12, 13, 40})
      for (const auto& [in, out] : {std::pair{1, 16}, {8, 64}, {51, 48}, {1200, 16}}) {
        const auto x = Normals(static_cast<std::size_t>(rows) * in, "x"),
                   w = Normals(static_cast<std::size_t>(in) * out, "w"), b = Normals(out, "b");
        std::vector<float> y(static_cast<std::size_t>(rows) * out);
        kernels.linear(x.data(), rows, in, out, {w.data(), b.data()}, y.data());
        CheckClose(y.data(), Linear({x.begin(), x.end()}, rows, in, out, w.data(), b.data()), 1e-5 * (in + 10));
      }
  });
}

TEST_CASE("pooling takes mean, maximum and softmax-weighted means over all rows") {
  WithEveryKernel([](const Kernels& kernels) {
    for (const int width : {16, 64})
      for (const int rows : {1, 5, 63, 64, 65, 300}) {
        const Block block(width);
        const auto x = Normals(static_cast<std::size_t>(rows) * width, "x");
        std::vector<float> pooled(6 * width);
        kernels.pool(x.data(), rows, width, block.Packed(), pooled.data());
        const auto u = Normed(x, rows, width, block.scale, block.shift);
        std::vector<double> expected(6 * width, 0.0);
        for (int i = 0; i < width; ++i) expected[width + i] = -1e30;
        double total[4] = {};
        for (int r = 0; r < rows; ++r) {
          for (int h = 0; h < 4; ++h) {
            double score = block.attention_bias[h];
            for (int i = 0; i < width; ++i) score += u[r * width + i] * block.attention[h * width + i];
            total[h] += std::exp(score);
            for (int i = 0; i < width; ++i) expected[(2 + h) * width + i] += std::exp(score) * u[r * width + i];
          }
          for (int i = 0; i < width; ++i) {
            expected[i] += u[r * width + i] / rows;
            expected[width + i] = std::max(expected[width + i], u[r * width + i]);
          }
        }
        for (int h = 0; h < 4; ++h)
          for (int i = 0; i < width; ++i) expected[(2 + h) * width + i] /= total[h];
        CheckClose(pooled.data(), expected, 5e-5);
      }
  });
}

TEST_CASE("the pooled block adds its output to each row and touches none behind them") {
  WithEveryKernel([](const Kernels& kernels) {
    for (const int width : {16, 48, 64})
      for (const int rows : {1, 7, 12, 25}) {
        const Block block(width);
        const auto set = Normals(2 * width, "set values");
        auto x = Normals(static_cast<std::size_t>(rows + 1) * width, "x");
        const std::vector<float> before = x;
        kernels.transform(x.data(), rows, width, block.Packed(), set.data());
        auto hidden = Linear(Normed(before, rows, width, block.scale, block.shift), rows, width, 2 * width,
                             block.point.data(), set.data());
        for (double& value : hidden) value = Gelu(value);
        auto expected = Linear(hidden, rows, 2 * width, width, block.output.data(), block.output_bias.data());
        for (std::size_t i = 0; i < expected.size(); ++i) expected[i] += before[i];
        CheckClose(x.data(), expected, 2e-4);
        CHECK(std::equal(x.end() - width, x.end(), before.end() - width));
      }
  });
}

TEST_CASE("projections, inputs and the logistic functions are theirs") {
  WithEveryKernel([](const Kernels& kernels) {
    const int width = 32, rows = 9;
    const auto x = Normals(rows * width, "x"), scale = Normals(width, "scale"), shift = Normals(width, "shift"),
               w = Normals(2 * width, "w"), constant = Normals(width, "constant"), inputs = Normals(2 * rows, "inputs");
    std::vector<float> out(rows);
    const PackedNorm norm{scale.data(), shift.data()};
    kernels.project(x.data(), rows, width, &norm, w.data(), 0.5f, out.data());
    const auto normed = Normed(x, rows, width, scale, shift);
    for (int r = 0; r < rows; ++r) {
      double sum = 0.5;
      for (int i = 0; i < width; ++i) sum += normed[r * width + i] * w[i];
      CHECK(out[r] == Approx(sum).margin(1e-4));
    }
    std::vector<float> sums(rows * width);
    const float* columns[2] = {inputs.data(), inputs.data() + rows};
    kernels.add_inputs(x.data(), rows, width, constant.data(), columns, w.data(), 2, sums.data());
    for (int r = 0; r < rows; ++r)
      for (int i = 0; i < width; ++i)
        CHECK(sums[r * width + i] ==
              Approx(x[r * width + i] + constant[i] + inputs[r] * w[i] + inputs[rows + r] * w[width + i]).margin(1e-5));
    std::vector<float> logits = {-200.0f, -30.0f, -3.0f, -0.1f, 0.0f, 0.1f, 3.0f, 30.0f, 200.0f}, confidences = logits;
    kernels.sigmoid(logits.data(), logits.size());
    kernels.confidence(confidences.data(), confidences.size());
    const std::vector<double> at = {-200.0, -30.0, -3.0, -0.1, 0.0, 0.1, 3.0, 30.0, 200.0};
    for (std::size_t i = 0; i < at.size(); ++i) {
      CHECK(logits[i] == Approx(1.0 / (1.0 + std::exp(-at[i]))).margin(1e-7));
      CHECK(confidences[i] == Approx(std::tanh(at[i] / 2.0)).margin(3e-7));
    }
  });
}
