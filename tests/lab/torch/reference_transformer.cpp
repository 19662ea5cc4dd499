#include "lab/torch/reference_transformer.h"

#include <cmath>
#include <utility>

namespace diffsac {

ReferenceTransformer::ReferenceTransformer(Weights weights, int width, int heads, int encoder_layers, int layers)
    : weights_(std::move(weights)), width_(width), heads_(heads), encoder_layers_(encoder_layers), layers_(layers) {}

ReferenceTransformer::Rows ReferenceTransformer::Linear(const std::string& name, const Rows& x) const {
  const auto& weight = weights_.at(name + ".weight");
  const auto& bias = weights_.at(name + ".bias");
  Rows y(x.size(), bias);
  for (std::size_t n = 0; n < x.size(); ++n)
    for (std::size_t o = 0; o < bias.size(); ++o)
      for (std::size_t i = 0; i < x[n].size(); ++i) y[n][o] += weight[o * x[n].size() + i] * x[n][i];
  return y;
}

ReferenceTransformer::Rows ReferenceTransformer::Norm(const std::string& name, const Rows& x) const {
  const auto& weight = weights_.at(name + ".weight");
  const auto& bias = weights_.at(name + ".bias");
  Rows y = x;
  for (auto& row : y) {
    double mean = 0.0, variance = 0.0;
    for (const double v : row) mean += v / row.size();
    for (const double v : row) variance += (v - mean) * (v - mean) / row.size();
    for (std::size_t i = 0; i < row.size(); ++i)
      row[i] = (row[i] - mean) / std::sqrt(variance + 1e-5) * weight[i] + bias[i];
  }
  return y;
}

ReferenceTransformer::Rows ReferenceTransformer::Mlp(const std::string& name, const Rows& x) const {
  Rows hidden = Linear(name + ".c_fc", x);
  for (auto& row : hidden)
    for (double& v : row) v = 0.5 * v * (1.0 + std::erf(v / std::sqrt(2.0)));
  return Linear(name + ".c_proj", hidden);
}

ReferenceTransformer::Rows ReferenceTransformer::Attention(const std::string& name, const Rows& x) const {
  const Rows qkv = Linear(name + ".c_qkv", x);
  const int points = static_cast<int>(x.size()), head_width = width_ / heads_;
  const double scale = 1.0 / std::sqrt(std::sqrt(static_cast<double>(head_width)));
  Rows mixed(points, std::vector<double>(width_, 0.0));
  for (int h = 0; h < heads_; ++h) {
    // Within a head's 3·C values: C of q, C of k, C of v.
    const int q = h * 3 * head_width, k = q + head_width, v = k + head_width;
    for (int a = 0; a < points; ++a) {
      std::vector<double> weight(points);
      double total = 0.0;
      for (int b = 0; b < points; ++b) {
        double dot = 0.0;
        for (int c = 0; c < head_width; ++c) dot += (qkv[a][q + c] * scale) * (qkv[b][k + c] * scale);
        total += weight[b] = std::exp(dot);
      }
      for (int b = 0; b < points; ++b)
        for (int c = 0; c < head_width; ++c) mixed[a][h * head_width + c] += weight[b] / total * qkv[b][v + c];
    }
  }
  return Linear(name + ".c_proj", mixed);
}

ReferenceTransformer::Rows ReferenceTransformer::Block(const std::string& name, Rows x) const {
  const auto add = [](Rows& to, const Rows& from) {
    for (std::size_t n = 0; n < to.size(); ++n)
      for (std::size_t i = 0; i < to[n].size(); ++i) to[n][i] += from[n][i];
  };
  add(x, Attention(name + ".attn", Norm(name + ".ln_1", x)));
  add(x, Mlp(name + ".mlp", Norm(name + ".ln_2", x)));
  return x;
}

std::vector<double> ReferenceTransformer::Run(const std::vector<double>& features, const std::vector<double>& c_t,
                                              double t) const {
  const std::size_t points = c_t.size(), columns = features.size() / points;
  Rows x(points), c(points);
  for (std::size_t n = 0; n < points; ++n) {
    x[n].assign(features.begin() + n * columns, features.begin() + (n + 1) * columns);
    c[n] = {c_t[n]};
  }
  Rows condition = Linear("input_points", x);
  if (encoder_layers_ > 0) {
    condition = Norm("ln_encoder_pre", condition);
    for (int i = 0; i < encoder_layers_; ++i) condition = Block("encoder" + std::to_string(i), condition);
    condition = Norm("ln_encoder_post", condition);
  }
  Rows embedding(1, std::vector<double>(width_));
  for (int i = 0; i < width_ / 2; ++i) {
    const double angle = t * std::pow(10000.0, -static_cast<double>(i) / (width_ / 2));
    embedding[0][i] = std::cos(angle);
    embedding[0][width_ / 2 + i] = std::sin(angle);
  }
  const Rows time = Mlp("time_embed", embedding);
  Rows h = Linear("input_confidence", c);
  for (std::size_t n = 0; n < points; ++n)
    for (int i = 0; i < width_; ++i) h[n][i] += condition[n][i] + time[0][i];
  h = Norm("ln_pre", h);
  for (int i = 0; i < layers_; ++i) h = Block("block" + std::to_string(i), h);
  const Rows out = Linear("output_proj", Norm("ln_post", h));
  std::vector<double> result;
  for (const auto& row : out) result.push_back(row[0]);
  return result;
}

}  // namespace diffsac
