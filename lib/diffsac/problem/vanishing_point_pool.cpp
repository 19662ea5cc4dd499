#include "diffsac/problem/vanishing_point_pool.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "diffsac/problem/segment_columns.h"

namespace diffsac {
namespace {

using Models = std::vector<Eigen::Vector3f>;
using Rows = VanishingPointPool::Rows;

constexpr float kDegree = static_cast<float>(std::numbers::pi / 180.0);

// How the pool is made; chosen on NYU-VP's validation images (docs/several.md).
constexpr float kSupportDegrees[] = {1.0f, 2.0f};
constexpr int kInTurn = 12, kBest = 32, kOrthogonalOf = 6;
constexpr float kApartInTurn = 2.0f, kApartBest = 3.0f, kApartOrthogonal = 5.0f, kApartInPool = 1.0f;
constexpr float kNearlyOrthogonal = 10.0f;
constexpr float kScoreDegrees = 1.5f, kRefineDegrees = 1.0f, kLengthPower = 1.5f, kFinalLengthPower = 3.0f;
constexpr int kRefineSteps = 3;

float SquaredSine(float degrees) { return std::pow(std::sin(degrees * kDegree), 2.0f); }
float Cosine(float degrees) { return std::cos(degrees * kDegree); }

Eigen::ArrayXf Support(const Eigen::ArrayXf& squares, float square) { return (1.0f - squares / square).max(0.0f); }

/// Appends the scores of the models that have none yet.
void AddScores(const SegmentColumns& segments, const Models& models, std::vector<float>* scores) {
  for (std::size_t i = scores->size(); i < models.size(); ++i)
    scores->push_back((Support(segments.Squares(models[i]), SquaredSine(kScoreDegrees)) * segments.length).sum());
}

/// The place of the largest value among those that are open; -1 where none is.
Eigen::Index BestOf(const Eigen::VectorXf& values, const std::vector<bool>& open) {
  Eigen::Index best = -1;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (open[i] && (best < 0 || values[i] > values[best])) best = i;
  return best;
}

std::vector<int> BestFirst(const std::vector<float>& scores) {
  std::vector<int> order(scores.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return scores[a] > scores[b]; });
  return order;
}

/// Those in their order that are so far from all before them.
std::vector<int> Apart(const Models& models, const std::vector<int>& order, float degrees, int most) {
  std::vector<int> kept;
  const float cosine = Cosine(degrees);
  for (const int i : order) {
    if (static_cast<int>(kept.size()) == most) break;
    const bool apart =
        std::none_of(kept.begin(), kept.end(), [&](int k) { return std::abs(models[i].dot(models[k])) > cosine; });
    if (apart) kept.push_back(i);
  }
  return kept;
}

/// The model of most support, again and again, by what of the segments those before it leave.
std::vector<int> InTurn(const Rows& support, const Models& models, const Eigen::ArrayXf& lengths) {
  std::vector<int> kept;
  std::vector<bool> alive(models.size(), true);
  Eigen::VectorXf left = lengths;
  while (static_cast<int>(kept.size()) < kInTurn) {
    const Eigen::VectorXf scores = support * left;
    const Eigen::Index best = BestOf(scores, alive);
    if (best < 0 || !(scores[best] > 1e-9f)) break;
    kept.push_back(static_cast<int>(best));
    for (std::size_t i = 0; i < models.size(); ++i)
      if (std::abs(models[i].dot(models[best])) > Cosine(kApartInTurn)) alive[i] = false;
    left.array() *= 1.0f - support.row(best).transpose().array();
  }
  return kept;
}

/// Indices of hypotheses worth refining.
std::vector<int> Candidates(const SegmentColumns& segments, const Models& models) {
  std::vector<int> candidates;
  Rows squares(static_cast<Eigen::Index>(models.size()), segments.count());
  for (std::size_t i = 0; i < models.size(); ++i)
    squares.row(static_cast<Eigen::Index>(i)) = segments.Squares(models[i]);
  for (const float degrees : kSupportDegrees) {
    const Rows support = (1.0f - squares.array() / SquaredSine(degrees)).max(0.0f);
    const std::vector<int> in_turn = InTurn(support, models, segments.length);
    const Eigen::VectorXf sums = support * segments.length.matrix();
    const std::vector<int> best = Apart(models, BestFirst({sums.data(), sums.data() + sums.size()}), kApartBest, kBest);
    candidates.insert(candidates.end(), in_turn.begin(), in_turn.end());
    candidates.insert(candidates.end(), best.begin(), best.end());
  }
  std::sort(candidates.begin(), candidates.end());
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  return candidates;
}

/// A few steps of reweighted least squares on the sphere, with the loss of Geman and McClure.
Eigen::Vector3f Refined(const SegmentColumns& s, const Eigen::ArrayXf& weights, Eigen::Vector3f v) {
  constexpr float kLongestStep = 0.1f;
  const float square = SquaredSine(kRefineDegrees);
  for (int step = 0; step < kRefineSteps; ++step) {
    const Eigen::Vector3f first = v.unitOrthogonal(), second = v.cross(first);
    const Eigen::ArrayXf distance = s.a * v[0] + s.b * v[1] + s.c * v[2];
    const Eigen::ArrayXf reach = (v[0] - v[2] * s.x).square() + (v[1] - v[2] * s.y).square() + 1e-18f;
    const Eigen::ArrayXf weight = weights / (1.0f + distance.square() / (reach * square)).square() / (square * reach);
    const Eigen::ArrayXf j1 = s.a * first[0] + s.b * first[1] + s.c * first[2];
    const Eigen::ArrayXf j2 = s.a * second[0] + s.b * second[1] + s.c * second[2];
    const float h11 = (weight * j1 * j1).sum(), h12 = (weight * j1 * j2).sum(), h22 = (weight * j2 * j2).sum();
    const float g1 = (weight * j1 * distance).sum(), g2 = (weight * j2 * distance).sum();
    const float determinant = h11 * h22 - h12 * h12;
    if (!(determinant > 1e-12f * (h11 + h22) * (h11 + h22))) break;
    Eigen::Vector2f change(-(h22 * g1 - h12 * g2) / determinant, -(h11 * g2 - h12 * g1) / determinant);
    if (change.norm() > kLongestStep) change *= kLongestStep / change.norm();
    v = (v + change[0] * first + change[1] * second).normalized();
  }
  return v;
}

/// The third directions of a room, of the best that are nearly orthogonal.
void AddOrthogonal(const std::vector<float>& scores, Models* models) {
  const std::vector<int> best = Apart(*models, BestFirst(scores), kApartOrthogonal, kOrthogonalOf);
  const float sine = std::sin(kNearlyOrthogonal * kDegree);
  for (std::size_t i = 0; i < best.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector3f a = (*models)[best[i]], b = (*models)[best[j]];
      if (std::abs(a.dot(b)) < sine) models->push_back(a.cross(b).normalized());
    }
}

// Of the features.
constexpr float kAngles[] = {0.3f, 0.6f, 1.2f, 2.4f, 5.0f};  // degrees
constexpr int kMemberAngle = 2;                              // the one by which segments belong to models
constexpr float kDistances[] = {0.5f, 1.0f, 2.0f, 4.0f};     // of the ends, pixels of an image that is 640 wide
constexpr float kPixel = 1.0f / 320.0f;
constexpr float kScales[] = {1.5f, 3.0f, 6.0f, 12.0f};  // degrees, of pairs

// Logarithms that are about 0 and of about unit size.
float Log(float value) { return 0.5f * (std::log(value + 0.02f) + 1.0f); }

/// The features of one model that ask for no other; members: how far each segment belongs to it.
class ModelFeatures {
 public:
  ModelFeatures(const SegmentColumns& s, const Eigen::Vector3f& v, float* out, Eigen::ArrayXf* members) : out_(out) {
    const Eigen::ArrayXf squares = s.Squares(v);
    const float total = s.length.sum();
    std::array<float, std::size(kAngles)> lengths;
    Eigen::ArrayXf near;
    for (std::size_t k = 0; k < std::size(kAngles); ++k) {
      near = (squares * (-0.5f / SquaredSine(kAngles[k]))).exp();
      lengths[k] = (s.length * near).sum();
      out[k] = Log(lengths[k]);
      out[5 + k] = Log(near.sum() / 20.0f);
      out[10 + k] = Log(3.0f * (s.length.square() * near).sum());
      if (k == kMemberAngle) *members = near;
    }
    out_ = out + 15;
    const Eigen::ArrayXf ends = squares * s.length.square() * 0.25f;
    for (const float pixels : kDistances) {
      const float scale = pixels * kPixel;
      Put(Log((s.length * (ends * (-0.5f / (scale * scale))).exp()).sum()));
    }
    PutSpread(s, v, s.length * *members);
    Put(0.5f * (std::log(total + 0.02f) - 4.0f));
    Put(0.5f * (std::log(static_cast<float>(s.count())) - 6.0f));
    out_ += 3;  // Those of the whole pool: AddRivalry.
    for (const float length : lengths) Put(Log(length / (total + 1e-9f)));
    for (const float value : {v[0] * v[0], v[1] * v[1], v[2] * v[2], v[1] * v[2], std::abs(v[0]), std::abs(v[1]),
                              std::abs(v[2]), v[0] * v[1], v[0] * v[2]})
      Put(value);
  }

 private:
  void Put(float value) { *out_++ = value; }

  /// How parallel the lines of the support are where it is, how long its longest segment is, how far it is spread.
  void PutSpread(const SegmentColumns& s, const Eigen::Vector3f& v, const Eigen::ArrayXf& weights) {
    const Eigen::ArrayXf wx = v[0] - v[2] * s.x, wy = v[1] - v[2] * s.y;
    const Eigen::ArrayXf scale = weights / (wx.square() + wy.square() + 1e-18f);
    const float sum = weights.sum() + 1e-9f;
    const float cosine = (scale * (wx.square() - wy.square())).sum(), sine = (2.0f * scale * wx * wy).sum();
    Put(std::hypot(cosine, sine) / sum);
    Put(weights.maxCoeff());
    const float mx = (weights * s.x).sum() / sum, my = (weights * s.y).sum() / sum;
    const float xx = (weights * s.x.square()).sum() / sum - mx * mx;
    const float yy = (weights * s.y.square()).sum() / sum - my * my;
    const float xy = (weights * s.x * s.y).sum() / sum - mx * my;
    Put(std::sqrt(std::max(0.0f, xx) + std::max(0.0f, yy)));
    Put(std::sqrt(std::sqrt(std::max(0.0f, xx * yy - xy * xy))));
  }

  float* out_;
};

constexpr int kOfPool = 25;  // The first of the features that compare a model with the others.

/// In the order of most support by what the others before leave: that support, the place; and how much of its support
/// is its own where all of the pool compete.
void AddRivalry(const Rows& members, const Eigen::ArrayXf& lengths, Rows* features) {
  const Eigen::Index count = members.rows();
  Eigen::VectorXf left = lengths;
  std::vector<bool> open(count, true);
  for (Eigen::Index place = 0; place < count; ++place) {
    const Eigen::VectorXf scores = members * left;
    const Eigen::Index best = BestOf(scores, open);
    open[best] = false;
    (*features)(best, kOfPool) = Log(scores[best]);
    (*features)(best, kOfPool + 1) = 0.5f * (std::log1p(static_cast<float>(place)) - 3.0f);
    left.array() *= 1.0f - members.row(best).transpose().array();
  }
  const Eigen::VectorXf shared = lengths / members.colwise().sum().transpose().array().max(1e-6f);
  const Eigen::VectorXf own = members.array().square().matrix() * shared;
  const Eigen::VectorXf all = members * lengths.matrix();
  features->col(kOfPool + 2) = own.array() / all.array().max(1e-6f);
}

/// How near in angle, how near to orthogonal, at four scales each; and the cosine of their supports.
Rows PairFeatures(const Models& models, const Rows& members, const Eigen::ArrayXf& lengths) {
  const auto count = static_cast<Eigen::Index>(models.size());
  const Rows common = members * lengths.matrix().asDiagonal() * members.transpose();
  Rows pairs(count * count, kPoolPairs);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j) {
      const float angle = std::acos(std::min(1.0f, std::abs(models[i].dot(models[j])))) / kDegree;
      float* out = pairs.data() + (i * count + j) * kPoolPairs;
      for (const float scale : kScales) *out++ = std::exp(-0.5f * std::pow(angle / scale, 2.0f));
      for (const float scale : kScales) *out++ = std::exp(-0.5f * std::pow((90.0f - angle) / scale, 2.0f));
      *out = common(i, j) / std::sqrt(std::max(1e-6f, common(i, i)) * std::max(1e-6f, common(j, j)));
    }
  return pairs;
}

}  // namespace

VanishingPointPool MakeVanishingPointPool(const PointMatrix& points, const Eigen::VectorXd& lengths,
                                          const std::vector<Eigen::Vector3d>& hypotheses) {
  const SegmentColumns segments(points, lengths);
  Models drawn;
  for (const Eigen::Vector3d& hypothesis : hypotheses) drawn.push_back(hypothesis.cast<float>().normalized());
  const Eigen::ArrayXf weights = segments.length.pow(kLengthPower);
  Models refined;
  for (const int i : Candidates(segments, drawn)) refined.push_back(Refined(segments, weights, drawn[i]));
  std::vector<float> scores;
  AddScores(segments, refined, &scores);
  AddOrthogonal(scores, &refined);
  AddScores(segments, refined, &scores);

  VanishingPointPool pool;
  Models models;
  for (const int i : Apart(refined, BestFirst(scores), kApartInPool, kPoolSize)) {
    models.push_back(refined[i]);
    pool.models.push_back(refined[i].cast<double>().normalized());
  }
  const auto count = static_cast<Eigen::Index>(models.size());
  Rows members(count, segments.count());
  pool.features.resize(count, kPoolFeatures);
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::ArrayXf row;
    ModelFeatures(segments, models[i], pool.features.row(i).data(), &row);
    members.row(i) = row;
  }
  if (count > 0) AddRivalry(members, segments.length, &pool.features);
  pool.pairs = PairFeatures(models, members, segments.length);
  return pool;
}

std::vector<ModelParameters> RefineOnLongest(const PointMatrix& points, const Eigen::VectorXd& lengths,
                                             const std::vector<Eigen::Vector3d>& models) {
  const SegmentColumns segments(points, lengths);
  const Eigen::ArrayXf weights = segments.length.pow(kFinalLengthPower);
  std::vector<ModelParameters> refined;
  for (const Eigen::Vector3d& model : models)
    refined.emplace_back(Refined(segments, weights, model.cast<float>().normalized()).cast<double>().normalized());
  return refined;
}

}  // namespace diffsac
