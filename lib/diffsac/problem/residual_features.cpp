#include "diffsac/problem/residual_features.h"

#include <algorithm>
#include <concepts>
#include <numeric>
#include <queue>

#include "diffsac/problem/residual_kernels.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

using FeatureMatrix = decltype(FeatureSet::values);

// MSAC ranks hypotheses best at 1.5 ε (field measurements: docs/generators.md).
constexpr double kScoreThresholdFactor = 1.5;
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

// Points, a coordinate a column, in blocks that stay in the processor's first cache.
class Blocks {
 public:
  static constexpr int kSize = 128;

  Blocks(const PointMatrix& points, double threshold) : axes_(points), threshold_(threshold) {}

  int points() const { return static_cast<int>(axes_.rows()); }
  double threshold() const { return threshold_; }

  // Calls use(first, count) for each block.
  template <class Use>
  void ForEach(const Use& use) const {
    for (int first = 0; first < points(); first += kSize) use(first, std::min(kSize, points() - first));
  }

  // Residuals of a block of points to one model.
  template <class Model>
  void Residuals(const double* model, int first, int count, double* out) const {
    const double* columns[Model::kDimension];
    for (int k = 0; k < Model::kDimension; ++k) columns[k] = axes_.col(k).data() + first;
    if constexpr (std::same_as<Model, Line> || std::same_as<Model, Plane>) {
      HyperplaneResiduals(model, Model::kDimension, columns, count, out);
    } else {
      Model::Residuals(Eigen::Map<const typename Model::Parameters>(model), columns, 0, count, out);
      LimitResiduals(kFarthest * threshold_, count, out);
    }
  }

 private:
  Eigen::MatrixXd axes_;
  double threshold_;
};

template <class Model>
void ScoreByMsac(const Blocks& blocks, double threshold, Pool* pool) {
  const double inverse = 1.0 / (threshold * threshold);
  pool->scores.setZero(pool->count);
  double residuals[Blocks::kSize];
  blocks.ForEach([&](int first, int count) {
    for (int h = 0; h < pool->count; ++h) {
      blocks.Residuals<Model>(pool->models.col(h).data(), first, count, residuals);
      pool->scores[h] += SumOfGains(residuals, inverse, count);
    }
  });
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
std::vector<int> Spread(const Blocks& blocks, double threshold, const Pool& pool, int kept) {
  const double inverse = 1.0 / (threshold * threshold);
  Eigen::ArrayXXf gains(blocks.points(), pool.count);
  double residuals[Blocks::kSize];
  blocks.ForEach([&](int first, int count) {
    for (int h = 0; h < pool.count; ++h) {
      blocks.Residuals<Model>(pool.models.col(h).data(), first, count, residuals);
      WriteGains(residuals, inverse, count, gains.col(h).data() + first);
    }
  });
  Eigen::ArrayXf covered = Eigen::ArrayXf::Zero(blocks.points());
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

// Writes the three columns of each kept hypothesis, from column `first_column` on.
template <class Model>
void WriteColumns(const Blocks& blocks, const Pool& pool, const std::vector<int>& best, int kept, int first_column,
                  FeatureMatrix* values) {
  if (best.empty()) {
    values->middleCols(first_column, kColumnsPerHypothesis * kept).setZero();
    return;
  }
  const auto different = std::min(kept, static_cast<int>(best.size()));
  std::vector<float> score(different), agreement(different * Blocks::kSize), distance(different * Blocks::kSize);
  for (int j = 0; j < different; ++j) score[j] = static_cast<float>(pool.scores[best[j]] / blocks.points());
  double residuals[Blocks::kSize];
  blocks.ForEach([&](int first, int count) {
    for (int j = 0; j < different; ++j) {
      blocks.Residuals<Model>(pool.models.col(best[j]).data(), first, count, residuals);
      WriteAgreement(residuals, blocks.threshold(), count, &agreement[j * Blocks::kSize], &distance[j * Blocks::kSize]);
    }
    for (int i = 0; i < count; ++i) {
      float* out = &(*values)(first + i, first_column);
      for (int k = 0; k < kept; ++k, out += kColumnsPerHypothesis) {
        const int j = k < different ? k : 0;
        out[0] = agreement[j * Blocks::kSize + i];
        out[1] = distance[j * Blocks::kSize + i];
        out[2] = score[j];
      }
    }
  });
}

template <class Model>
void Describe(const NormalizedProblem& space, const std::vector<int>& sets, const KeptHypotheses& kept, int first,
              FeatureSet* features) {
  const Blocks blocks(space.points(), space.threshold());
  Pool pool = SolveSets<Model>(space.points(), sets);
  const double score_threshold = kScoreThresholdFactor * space.threshold();
  ScoreByMsac<Model>(blocks, score_threshold, &pool);
  const std::vector<int> best = kept.choice == ResidualChoice::kSpread
                                    ? Spread<Model>(blocks, score_threshold, pool, kept.count)
                                    : BestDistinct(pool, Model::kMinimalSize, kept.count);
  WriteColumns<Model>(blocks, pool, best, kept.count, first, &features->values);
  features->hypotheses = pool.count;
  for (int h : best) {
    features->models.emplace_back(pool.models.col(h));
    features->scores.push_back(pool.scores[h]);
  }
}

}  // namespace

void AddResidual(const NormalizedProblem& space, const std::vector<int>& sets, const KeptHypotheses& kept, int first,
                 FeatureSet* features) {
  DispatchTask(space.problem().task, [&]<class Model>() { Describe<Model>(space, sets, kept, first, features); });
}

}  // namespace diffsac
