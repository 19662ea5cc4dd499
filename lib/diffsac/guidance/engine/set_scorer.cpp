#include "diffsac/guidance/engine/set_scorer.h"

#include <cmath>
#include <numbers>
#include <span>

namespace diffsac {
namespace {

using Rows = SetScorer::Rows;

void Gelu(Rows* x) {
  constexpr float kRoot = static_cast<float>(1.0 / std::numbers::sqrt2);
  for (Eigen::Index i = 0; i < x->size(); ++i) {
    float& value = x->data()[i];
    value = 0.5f * value * (1.0f + std::erf(value * kRoot));
  }
}

void Softmax(Rows* x) {
  for (Eigen::Index i = 0; i < x->rows(); ++i) {
    auto row = x->row(i).array();
    row = (row - row.maxCoeff()).exp();
    row /= row.sum();
  }
}

Rows ReadMatrix(const SetScorer::ReadTensor& read, const std::string& name, std::int64_t rows, std::int64_t cols) {
  Rows matrix(rows, cols);
  read(name, {rows, cols}, std::span<float>(matrix.data(), static_cast<std::size_t>(matrix.size())));
  return matrix;
}

Eigen::RowVectorXf ReadVector(const SetScorer::ReadTensor& read, const std::string& name, std::int64_t size) {
  Eigen::RowVectorXf vector(size);
  read(name, {size}, std::span<float>(vector.data(), static_cast<std::size_t>(size)));
  return vector;
}

}  // namespace

SetScorerOptions ReadSetScorerOptions(const StoredOptions& network) {
  SetScorerOptions options;
  network.Read("width", &options.width, 4, 1024);
  network.Read("heads", &options.heads, 1, 64);
  network.Read("layers", &options.layers, 1, 64);
  network.Read("hidden", &options.hidden, 1, 4096);
  network.Read("pair_width", &options.pair_width, 1, 1024);
  network.Require(options.width % options.heads == 0, "heads", "a divisor of width");
  return options;
}

SetScorer::SetScorer(const SetScorerOptions& options, int features, int pairs, const ReadTensor& read)
    : options_(options) {
  const auto linear = [&](const std::string& name, int out, int in) {
    return Linear{ReadMatrix(read, name + ".weight", out, in), ReadVector(read, name + ".bias", out)};
  };
  const auto norm = [&](const std::string& name) {
    return Norm{ReadVector(read, name + ".weight", options.width), ReadVector(read, name + ".bias", options.width)};
  };
  taken_ = ReadVector(read, "taken", options.width);
  input_ = linear("input", options.width, features);
  pair_hidden_ = linear("pair_hidden", options.pair_width, pairs);
  pair_output_ = linear("pair_output", options.heads * options.layers, options.pair_width);
  for (int i = 0; i < options.layers; ++i) {
    const std::string name = "layer" + std::to_string(i) + ".";
    layers_.push_back({norm(name + "before_attention"), norm(name + "before_hidden"),
                       linear(name + "attention", 3 * options.width, options.width),
                       linear(name + "output", options.width, options.width),
                       linear(name + "hidden", options.hidden, options.width),
                       linear(name + "back", options.width, options.hidden)});
  }
  score_norm_ = norm("score_norm");
  score_hidden_ = linear("score_hidden", options.width, options.width);
  score_ = linear("score", 1, options.width);
}

Rows SetScorer::Linear::operator()(const Rows& x) const {
  Rows y(x.rows(), weight.rows());
  y.noalias() = x * weight.transpose();
  y.rowwise() += bias;
  return y;
}

Rows SetScorer::Norm::operator()(const Rows& x) const {
  constexpr float kEpsilon = 1e-5f;
  const Eigen::VectorXf mean = x.rowwise().mean();
  Rows y = x.colwise() - mean;
  const Eigen::ArrayXf scale = (y.array().square().rowwise().mean() + kEpsilon).rsqrt();
  y.array().colwise() *= scale;
  y.array().rowwise() *= weight.array();
  y.rowwise() += bias;
  return y;
}

SetScorer::Set::Set(const SetScorer& scorer, const Rows& values, const Rows& pairs) : scorer_(scorer) {
  embedded_ = scorer.input_(values);
  Rows hidden = scorer.pair_hidden_(pairs);
  Gelu(&hidden);
  const Rows added = scorer.pair_output_(hidden);
  for (Eigen::Index k = 0; k < added.cols(); ++k) {
    const Eigen::VectorXf column = added.col(k);
    biases_.emplace_back(Eigen::Map<const Rows>(column.data(), values.rows(), values.rows()));
  }
}

Rows SetScorer::Set::Attend(int layer, const Rows& x) const {
  const int width = scorer_.options_.width, heads = scorer_.options_.heads, own = width / heads;
  const Layer& weights = scorer_.layers_[static_cast<std::size_t>(layer)];
  const Rows qkv = weights.attention(weights.before_attention(x));
  Rows mixed(x.rows(), width);
  for (int h = 0; h < heads; ++h) {
    const auto q = qkv.middleCols(h * own, own), k = qkv.middleCols(width + h * own, own);
    Rows attention = q * k.transpose() / std::sqrt(static_cast<float>(own));
    attention += biases_[static_cast<std::size_t>(layer * heads + h)];
    Softmax(&attention);
    mixed.middleCols(h * own, own).noalias() = attention * qkv.middleCols(2 * width + h * own, own);
  }
  return x + weights.output(mixed);
}

Eigen::VectorXf SetScorer::Set::Score(const std::vector<std::uint8_t>& taken) const {
  Rows x = embedded_;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (taken[static_cast<std::size_t>(i)] != 0) x.row(i) += scorer_.taken_;
  for (std::size_t i = 0; i < scorer_.layers_.size(); ++i) {
    const Layer& weights = scorer_.layers_[i];
    x = Attend(static_cast<int>(i), x);
    Rows hidden = weights.hidden(weights.before_hidden(x));
    Gelu(&hidden);
    x += weights.back(hidden);
  }
  Rows hidden = scorer_.score_hidden_(scorer_.score_norm_(x));
  Gelu(&hidden);
  return scorer_.score_(hidden).col(0);
}

}  // namespace diffsac
