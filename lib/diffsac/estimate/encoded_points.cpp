#include "diffsac/estimate/encoded_points.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "diffsac/estimate/point_prior.h"

namespace diffsac {

void EncodedPoints::Choose(const Eigen::VectorXf& prior, int count, const FeatureSet& all) {
  prior_ = prior;
  rows_ = LikeliestPoints(prior, count);
  features_.values = all.values(rows_, Eigen::all);
}

void EncodedPoints::GiveToAll(Denoised* said) const {
  const auto count = static_cast<std::size_t>(prior_.size());
  const auto spread = [&](const std::vector<float>& some, float rest) {
    std::vector<float> all(some.size() / rows_.size() * count, rest);
    for (std::size_t i = 0; i < some.size(); ++i) all[i / rows_.size() * count + rows_[i % rows_.size()]] = some[i];
    return all;
  };
  constexpr float kNone = -std::numeric_limits<float>::infinity();
  said->confidences = spread(said->confidences, kNone);
  for (auto& step : said->steps) step = spread(step, kNone);
  if (said->weights.empty()) return;
  double of_prior = 0.0;
  for (const int i : rows_) of_prior += prior_[i];
  const double of_network = std::accumulate(said->weights.begin(), said->weights.end(), 0.0);
  const auto scale = static_cast<float>(of_prior > 0.0 ? std::min(1.0, of_network / of_prior) : 1.0);
  std::vector<float> weights(count);
  for (std::size_t i = 0; i < count; ++i) weights[i] = scale * prior_[static_cast<Eigen::Index>(i)];
  for (std::size_t i = 0; i < rows_.size(); ++i) weights[rows_[i]] = said->weights[i];
  said->weights = std::move(weights);
}

}  // namespace diffsac
