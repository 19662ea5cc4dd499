#include "diffsac/data/preference_features.h"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numeric>
#include <queue>

#include "diffsac/data/tasks.h"

namespace diffsac {
namespace {

using FeatureMatrix = decltype(FeatureSet::values);

// MSAC ranks hypotheses best at 1.5 ε (field measurements: docs/generators.md).
constexpr double kScoreThresholdFactor = 1.5;
// Soft agreement falls off with this multiple of ε.
constexpr float kAgreementSigma = 0.5f;
// log1p(r/ε) reaches about 4.9 across the synthetic picture; this brings it to about unit range.
constexpr float kDistanceScale = 0.25f;
// But for lines and planes: a residual beyond so many ε, or none at all (a point sent to infinity), counts as this
// many.
constexpr double kFarthest = 1e6;

// Hypotheses as they come out of the solver.
struct Pool {
  std::vector<int> sets;   // γ indices each; a set with several solutions stands here as often
  Eigen::MatrixXd models;  // parameters × H, one a column
  Eigen::ArrayXd scores;   // H
  int count = 0;
};

template <class Model>
Pool SolveSets(const PointMatrix& points, const std::vector<int>& sets) {
  constexpr int kSize = Model::kMinimalSize;
  const auto drawn = static_cast<int>(sets.size()) / kSize;
  Pool pool;
  pool.models.resize(Model::Parameters::SizeAtCompileTime, drawn * Model::kMaxSolutions);
  pool.sets.reserve(sets.size());
  typename Model::Parameters models[Model::kMaxSolutions];
  for (int i = 0; i < drawn; ++i) {
    const int* set = sets.data() + i * kSize;
    const int solutions = Model::SolveMinimal(points, set, models);
    for (int k = 0; k < solutions; ++k) {
      pool.models.col(pool.count++) = models[k];
      pool.sets.insert(pool.sets.end(), set, set + kSize);
    }
  }
  return pool;
}

// Residuals of all points to one model; `axes` holds a coordinate a column.
template <class Model>
auto Residuals(const Eigen::ArrayXXd& axes, const double* model, [[maybe_unused]] double threshold) {
  if constexpr (std::same_as<Model, Line>) {
    return (axes.col(0) * model[0] + axes.col(1) * model[1] + model[2]).abs();
  } else if constexpr (std::same_as<Model, Plane>) {
    return (axes.col(0) * model[0] + axes.col(1) * model[1] + axes.col(2) * model[2] + model[3]).abs();
  } else {
    const double* columns[Model::kDimension];
    for (int k = 0; k < Model::kDimension; ++k) columns[k] = axes.col(k).data();
    Eigen::ArrayXd residuals(axes.rows());
    Model::Residuals(Eigen::Map<const typename Model::Parameters>(model), columns, 0, static_cast<int>(axes.rows()),
                     residuals.data());
    const double farthest = kFarthest * threshold;
    for (double& r : residuals) r = r < farthest ? r : farthest;  // a NaN too
    return residuals;
  }
}

template <class Model>
void ScoreByMsac(const Eigen::ArrayXXd& axes, double threshold, Pool* pool) {
  const double inverse = 1.0 / (threshold * threshold);
  pool->scores.resize(pool->count);
  for (int h = 0; h < pool->count; ++h)
    pool->scores[h] =
        (1.0 - Residuals<Model>(axes, pool->models.col(h).data(), threshold).square() * inverse).max(0.0).sum();
}

// The best `kept` hypotheses with distinct sets, by score, then by order of drawing.
std::vector<int> BestDistinct(const Pool& pool, int set_size, int kept) {
  std::vector<int> order(pool.count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return pool.scores[a] != pool.scores[b] ? pool.scores[a] > pool.scores[b] : a < b; });
  const auto same_set = [&](int a, int b) {
    const int* first = pool.sets.data() + a * set_size;
    return std::equal(first, first + set_size, pool.sets.data() + b * set_size);
  };
  std::vector<int> best;
  for (int candidate : order) {
    if (static_cast<int>(best.size()) == kept) break;
    if (std::none_of(best.begin(), best.end(), [&](int other) { return same_set(candidate, other); }))
      best.push_back(candidate);
  }
  return best;
}

// One hypothesis after the other, each the one that explains most beyond what those before it explain: the greedy
// choice for Σ over points of the best MSAC gain, whose gains only fall, so that a bound from an earlier round decides
// most candidates unseen (Minoux, "Accelerated greedy algorithms for maximizing submodular set functions", 1978).
template <class Model>
std::vector<int> Spread(const Eigen::ArrayXXd& axes, double threshold, const Pool& pool, int kept) {
  const double inverse = 1.0 / (threshold * threshold);
  Eigen::ArrayXXf gains(axes.rows(), pool.count);
  for (int h = 0; h < pool.count; ++h)
    gains.col(h) = (1.0 - Residuals<Model>(axes, pool.models.col(h).data(), threshold).square() * inverse)
                       .max(0.0)
                       .template cast<float>();
  Eigen::ArrayXf covered = Eigen::ArrayXf::Zero(axes.rows());
  struct Candidate {
    float gain;
    int hypothesis;
    int round;  // in which the gain was reckoned
    bool operator<(const Candidate& other) const {
      return gain != other.gain ? gain < other.gain : hypothesis > other.hypothesis;
    }
  };
  std::priority_queue<Candidate> candidates;
  for (int h = 0; h < pool.count; ++h) candidates.push({gains.col(h).sum(), h, 0});
  std::vector<int> chosen;
  while (static_cast<int>(chosen.size()) < kept && !candidates.empty()) {
    const Candidate top = candidates.top();
    candidates.pop();
    const int round = static_cast<int>(chosen.size());
    if (top.round < round) {
      candidates.push({(gains.col(top.hypothesis) - covered).max(0.0f).sum(), top.hypothesis, round});
      continue;
    }
    chosen.push_back(top.hypothesis);
    covered = covered.max(gains.col(top.hypothesis));
  }
  return chosen;
}

// Writes the three columns of each kept hypothesis, from column `first` on.
template <class Model>
void WriteColumns(const Eigen::ArrayXXd& axes, double threshold, const Pool& pool, const std::vector<int>& best,
                  int kept, int first, FeatureMatrix* values) {
  if (best.empty()) {
    values->middleCols(first, kColumnsPerHypothesis * kept).setZero();
    return;
  }
  // Whole SIMD packets only: a value must not depend on where in the array its point stands.
  const Eigen::Index count = axes.rows(), padded = (count + 15) / 16 * 16;
  Eigen::ArrayXf scaled = Eigen::ArrayXf::Zero(padded);
  Eigen::ArrayXf agreement(padded), distance(padded);
  for (int j = 0; j < kept; ++j) {
    const int h = best[j < static_cast<int>(best.size()) ? j : 0];
    scaled.head(count) =
        (Residuals<Model>(axes, pool.models.col(h).data(), threshold) / threshold).template cast<float>();
    agreement = (scaled.square() * (-0.5f / (kAgreementSigma * kAgreementSigma))).exp();
    distance = (scaled + 1.0f).log() * kDistanceScale;
    const int column = first + kColumnsPerHypothesis * j;
    values->col(column) = agreement.head(count);
    values->col(column + 1) = distance.head(count);
    values->col(column + 2).setConstant(static_cast<float>(pool.scores[h] / static_cast<double>(count)));
  }
}

template <class Model>
void Describe(const SolverSpace& space, const std::vector<int>& sets, const KeptHypotheses& kept, int first,
              FeatureSet* features) {
  const Eigen::ArrayXXd axes = space.points().array();  // column-major: a coordinate is contiguous
  Pool pool = SolveSets<Model>(space.points(), sets);
  const double score_threshold = kScoreThresholdFactor * space.threshold();
  ScoreByMsac<Model>(axes, score_threshold, &pool);
  const std::vector<int> best = kept.choice == PreferenceChoice::kSpread
                                    ? Spread<Model>(axes, score_threshold, pool, kept.count)
                                    : BestDistinct(pool, Model::kMinimalSize, kept.count);
  WriteColumns<Model>(axes, space.threshold(), pool, best, kept.count, first, &features->values);
  features->hypotheses = pool.count;
  for (int h : best) {
    features->models.emplace_back(pool.models.col(h));
    features->scores.push_back(pool.scores[h]);
  }
}

}  // namespace

void AddPreference(const SolverSpace& space, const std::vector<int>& sets, const KeptHypotheses& kept, int first,
                   FeatureSet* features) {
  DispatchTask(space.problem().task, [&]<class Model>() { Describe<Model>(space, sets, kept, first, features); });
}

}  // namespace diffsac
