#include "diffsac/geometry/plane_and_parallax.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/square_bounds.h"

namespace diffsac {
namespace {

/// Transfer errors of a plane's points against Sampson distances: two more freedoms (χ² quantiles, 12 σ² to 3.8 σ²).
constexpr double kPlaneFactor = 1.7320508075688772;
/// An H through three noisy points errs more where it is extrapolated.
constexpr double kSetFactor = 2.0 * kPlaneFactor;
/// From here on the parallax is not the plane's noise, and worth a vote on the epipole.
constexpr double kParallaxFactor = 2.0 * kPlaneFactor;
constexpr int kMaxSetSize = 8;
constexpr int kSupportSets = 5;
constexpr int kPlaneRounds = 10;
constexpr int kMaxPairs = 1000;
/// Points off the plane that vote on an epipole.
constexpr int kMostOffPlane = 500;
constexpr double kPairConfidence = 0.999;
/// Two points define the epipole; fewer others than this prove nothing.
constexpr int kMinVotes = 1;
/// Sines below this are no angle.
constexpr double kMinSine = 1e-6;

Eigen::Vector3d First(const double* p) { return {p[0], p[1], 1.0}; }
Eigen::Vector3d Second(const double* p) { return {p[2], p[3], 1.0}; }

/// Whether three points of one image span a triangle.
bool SpansTriangle(const double (*points)[4], const int triplet[3], int offset) {
  const Eigen::Map<const Eigen::Vector2d> a(points[triplet[0]] + offset), b(points[triplet[1]] + offset),
      c(points[triplet[2]] + offset);
  const Eigen::Vector2d u = b - a, v = c - a;
  const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (c - b).squaredNorm()});
  return std::abs(u[0] * v[1] - u[1] * v[0]) > kMinSine * longest;
}

/// Points in the coordinates in which everything is computed: those of the set, one scale for both images, so that
/// distances keep their proportion.
class Scene {
 public:
  Scene(const PointMatrix& points, const PairNormalization& normalization) : points_(points.rows(), 4), columns_() {
    for (Eigen::Index i = 0; i < points.rows(); ++i) normalization.Apply(points.data() + 4 * i, points_.data() + 4 * i);
  }

  const PointMatrix& points() const { return points_; }
  int size() const { return static_cast<int>(points_.rows()); }
  const double* Point(int i) const { return points_.data() + 4 * static_cast<Eigen::Index>(i); }

  Eigen::VectorXd PlaneErrors(const Eigen::Matrix3d& h) {
    if (columns_.size() == 0) columns_ = points_;
    const double* pointers[4];
    for (int j = 0; j < 4; ++j) pointers[j] = columns_.col(j).data();
    Eigen::VectorXd errors(points_.rows());
    SymmetricTransferErrors(AsParameters(h), pointers, 0, size(), errors.data());
    return errors;
  }

 private:
  PointMatrix points_;
  Eigen::MatrixXd columns_;
};

/// `size` of these in random order.
std::vector<int> Drawn(const std::vector<int>& rows, int size, Rng& rng) {
  std::vector<int> places(size);
  rng.Distinct(static_cast<int>(rows.size()), size, places.data());
  for (int& place : places) place = rows[place];
  return places;
}

std::vector<int> InliersOf(const PointMatrix& points, const Matrix3Parameters& f, double threshold) {
  const Eigen::VectorXd distances = RowResiduals<Fundamental>(points, f);
  std::vector<int> inliers;
  for (int i = 0; i < points.rows(); ++i)
    if (distances[i] <= threshold) inliers.push_back(i);
  return inliers;
}

/// A plane that dominates what `f` was solved from, or else what supports it: then local optimisation would draw even
/// a sound f to the plane's points and to any epipole.
bool FindDominantPlane(const Scene& scene, const Matrix3Parameters& f, const int* set, int size, double limit, Rng* rng,
                       Eigen::Matrix3d* h) {
  double points[kMaxSetSize][4];
  const auto found_in = [&](const auto& member) {
    for (int i = 0; i < size; ++i) std::copy_n(scene.Point(member(i)), 4, points[i]);
    return FindPlaneInSet(AsMatrix(f), points, size, kSetFactor * limit, h);
  };
  if (found_in([&](int i) { return set[i]; })) return true;
  const std::vector<int> support = InliersOf(scene.points(), f, limit);
  if (static_cast<int>(support.size()) < size) return false;
  for (int draw = 0; draw < kSupportSets; ++draw) {
    const std::vector<int> chosen = Drawn(support, size, *rng);
    if (found_in([&](int i) { return chosen[i]; })) return true;
  }
  return false;
}

/// Least squares on the points near the plane, while there are more of them each time. Signed with w > 0 at the set.
bool FitPlane(Scene* scene, double threshold, Eigen::Matrix3d* h, Eigen::VectorXd* errors, int* fits) {
  *errors = scene->PlaneErrors(*h);
  Eigen::Index near = (errors->array() <= threshold).count();
  for (int round = 0; round < kPlaneRounds; ++round) {
    Matrix3Parameters fitted;
    ++*fits;
    if (!Homography::Fit(scene->points(), (errors->array() <= threshold).cast<double>(), &fitted)) break;
    const Eigen::VectorXd next = scene->PlaneErrors(AsMatrix(fitted));
    const Eigen::Index count = (next.array() <= threshold).count();
    if (count < near) break;
    *h = AsMatrix(fitted);
    *errors = next;
    if (count == near) break;
    near = count;
  }
  return h->allFinite() && near >= Homography::kMinimalSize;
}

/// Makes w positive for most points on the plane.
void SignPlane(const Scene& scene, const Eigen::VectorXd& errors, double threshold, Eigen::Matrix3d* h) {
  std::int64_t balance = 0;
  for (int i = 0; i < scene.size(); ++i)
    if (errors[i] <= threshold) balance += h->row(2).dot(First(scene.Point(i))) > 0.0 ? 1 : -1;
  if (balance < 0) *h = -*h;
}

/// The points off a plane, as columns, and how well they support an F. Of many a random part, so that the cost of a
/// pair does not grow with their number.
class OffPlane {
 public:
  OffPlane(const Scene& scene, const Eigen::VectorXd& errors, double threshold, Rng rng) : threshold_(threshold) {
    std::vector<int> off;
    for (int i = 0; i < scene.size(); ++i)
      if (!(errors[i] <= kPlaneFactor * threshold)) off.push_back(i);
    if (static_cast<int>(off.size()) > kMostOffPlane) off = Drawn(off, kMostOffPlane, rng);
    const auto near = std::stable_partition(off.begin(), off.end(),
                                            [&](int i) { return !(errors[i] <= kParallaxFactor * threshold); });
    far_.assign(off.begin(), near);
    columns_.resize(static_cast<Eigen::Index>(off.size()), 4);
    for (std::size_t i = 0; i < off.size(); ++i)
      columns_.row(static_cast<Eigen::Index>(i)) = scene.points().row(off[i]);
    distances_.resize(columns_.rows());
    for (int j = 0; j < 4; ++j) pointers_[j] = columns_.col(j).data();
    bounds_.emplace(pointers_, static_cast<int>(columns_.rows()));
  }

  /// Points whose parallax tells of the epipole.
  const std::vector<int>& far() const { return far_; }

  struct Support {
    double score = 0.0;  ///< Σ max(0, 1 − d²/threshold²)
    int votes = 0;       ///< of far points
  };

  /// Gives up, with what it has or nothing, once `score_to_beat` is out of reach.
  Support operator()(const Eigen::Matrix3d& f, double score_to_beat) {
    constexpr int kBlock = 64;
    const Matrix3Parameters model = AsParameters(f);
    const int size = static_cast<int>(columns_.rows());
    Support support;
    if (!MayReach(model, score_to_beat)) return support;
    for (int begin = 0; begin < size; begin += kBlock) {
      if (support.score + (size - begin) < score_to_beat) break;
      const int end = std::min(begin + kBlock, size);
      SampsonDistances(model.data(), pointers_, begin, end, distances_.data());
      for (int i = 0; i < end - begin; ++i) {
        const double share = distances_[i] / threshold_;
        if (!(share <= 1.0)) continue;
        support.score += 1.0 - share * share;
        support.votes += begin + i < static_cast<int>(far_.size()) ? 1 : 0;
      }
    }
    return support;
  }

 private:
  bool MayReach(const Matrix3Parameters& model, double score_to_beat) const {
    SampsonBounds::Prepared prepared;
    if (!(score_to_beat > 0.0) || !bounds_->Prepare(model, threshold_, &prepared)) return true;
    const int size = static_cast<int>(columns_.rows());
    std::array<float, kBoundBlock> squares;
    double most = 0.0;
    for (int begin = 0; begin < size && most + (size - begin) >= score_to_beat; begin += kBoundBlock) {
      const int end = std::min(begin + kBoundBlock, size);
      (*bounds_)(prepared, begin, end, squares.data());
      most += MsacBound(squares.data(), nullptr, end - begin);
      if (most >= score_to_beat) return true;
    }
    return false;
  }

  double threshold_;
  std::vector<int> far_;
  Eigen::Matrix<double, Eigen::Dynamic, 4> columns_;
  const double* pointers_[4];
  std::optional<SampsonBounds> bounds_;
  Eigen::VectorXd distances_;
};

/// Pairs that hit two of `votes` among `far` once with kPairConfidence.
int PairsNeeded(int votes, int far) {
  if (votes < 2) return kMaxPairs;
  const double good = static_cast<double>(votes) * (votes - 1) / (static_cast<double>(far) * (far - 1));
  if (!(good < 1.0)) return 1;
  const double needed = std::ceil(std::log(1.0 - kPairConfidence) / std::log1p(-good));
  return needed < kMaxPairs ? static_cast<int>(needed) : kMaxPairs;
}

/// The F = [e2]ₓ H of most support; false when no pair has another vote.
bool BestEpipole(const Scene& scene, const Eigen::Matrix3d& h, OffPlane* off, Rng* rng, Eigen::Matrix3d* best,
                 int* fits) {
  const std::vector<int>& far = off->far();
  const int count = static_cast<int>(far.size());
  if (count < 2 + kMinVotes) return false;
  OffPlane::Support most;
  const auto offer = [&](int a, int b) {
    Eigen::Matrix3d f;
    ++*fits;
    if (!FundamentalFromPlaneAndParallax(h, scene.Point(far[a]), scene.Point(far[b]), &f)) return;
    const OffPlane::Support support = (*off)(f, most.score);
    if (!(support.score > most.score)) return;
    most = support;
    *best = f;
  };
  if (static_cast<std::int64_t>(count) * (count - 1) / 2 <= kMaxPairs) {
    for (int a = 0; a < count; ++a)
      for (int b = a + 1; b < count; ++b) offer(a, b);
  } else {
    int needed = kMaxPairs;
    for (int trial = 0; trial < needed; ++trial) {
      int pair[2];
      rng->Distinct(count, 2, pair);
      offer(pair[0], pair[1]);
      needed = PairsNeeded(most.votes, count);
    }
  }
  return most.votes >= 2 + kMinVotes;
}

}  // namespace

bool PlaneHomography(const Eigen::Matrix3d& f, const double (*points)[4], const int triplet[3], Eigen::Matrix3d* h) {
  if (!SpansTriangle(points, triplet, 0) || !SpansTriangle(points, triplet, 2)) return false;
  const Eigen::Vector3d epipole = LeftEpipole(f).normalized();
  Eigen::Matrix3d a, m;
  for (int j = 0; j < 3; ++j) a.col(j) = epipole.cross(f.col(j));
  Eigen::Vector3d b;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d x1 = First(points[triplet[i]]), x2 = Second(points[triplet[i]]);
    const Eigen::Vector3d through = x2.cross(epipole);
    if (!(through.squaredNorm() > kMinSine * kMinSine * x2.squaredNorm())) return false;
    m.row(i) = x1.transpose();
    b[i] = x2.cross(a * x1).dot(through) / through.squaredNorm();
  }
  *h = a - epipole * (m.inverse() * b).transpose();
  return h->allFinite() && h->cwiseAbs().maxCoeff() > 0.0;
}

bool FindPlaneInSet(const Eigen::Matrix3d& f, const double (*points)[4], int size, double threshold,
                    Eigen::Matrix3d* h) {
  constexpr int kTriplets[5][3] = {{0, 1, 2}, {3, 4, 5}, {0, 1, 6}, {3, 4, 6}, {2, 5, 6}};
  const int majority = size - 2;
  int most = 0;
  double least = 0.0;
  for (const int(&triplet)[3] : kTriplets) {
    Eigen::Matrix3d plane;
    if (!PlaneHomography(f, points, triplet, &plane)) continue;
    const Matrix3Parameters model = AsParameters(plane);
    int near = 0;
    double sum = 0.0;
    for (int i = 0; i < size; ++i) {
      const double error = SymmetricTransferError(model, points[i]);
      if (!(error <= threshold)) continue;
      ++near;
      sum += error;
    }
    if (near < majority || near < most || (near == most && !(sum < least))) continue;
    most = near;
    least = sum;
    *h = plane;
  }
  return most >= majority;
}

bool FundamentalFromPlaneAndParallax(const Eigen::Matrix3d& h, const double* first, const double* second,
                                     Eigen::Matrix3d* f) {
  const Eigen::Vector3d on_plane[2] = {h * First(first), h * First(second)};
  const Eigen::Vector3d seen[2] = {Second(first), Second(second)};
  Eigen::Vector3d lines[2];
  for (int i = 0; i < 2; ++i) {
    lines[i] = seen[i].cross(on_plane[i]);
    const double length = lines[i].norm();
    if (!(length > 1e-14 * seen[i].norm() * on_plane[i].norm())) return false;
    lines[i] /= length;
  }
  Eigen::Vector3d epipole = lines[0].cross(lines[1]);
  const double sine = epipole.norm();
  if (!(sine > kMinSine)) return false;
  epipole /= sine;
  for (int i = 0; i < 2; ++i)
    if (!(epipole.cross(seen[i]).dot(epipole.cross(on_plane[i])) > 0.0)) return false;
  for (int j = 0; j < 3; ++j) f->col(j) = epipole.cross(h.col(j));
  return f->allFinite() && f->cwiseAbs().maxCoeff() > 0.0;
}

int RecoverFromPlane(const PointMatrix& points, const int* set, int size, const Matrix3Parameters& model,
                     double threshold, Rng rng, int max_models, Matrix3Parameters* out, int* fits) {
  std::vector<int> drawn_set;
  if (set == nullptr) {
    const std::vector<int> inliers = points.cols() == 4 ? InliersOf(points, model, threshold) : std::vector<int>();
    if (static_cast<int>(inliers.size()) < size) return 0;
    Rng set_rng = rng.Fork("set");
    drawn_set = Drawn(inliers, size, set_rng);
    set = drawn_set.data();
  }
  PairNormalization n;
  if (points.cols() != 4 || !model.allFinite() || !NormalizeSet(points, set, size, &n)) return 0;
  n.first.scale = n.second.scale = std::sqrt(n.first.scale * n.second.scale);
  const double limit = threshold * n.first.scale;
  if (!(limit > 0.0) || !std::isfinite(limit)) return 0;
  const Matrix3Parameters normalized =
      AsParameters(n.second.Inverse().transpose() * AsMatrix(model) * n.first.Inverse());
  if (!normalized.allFinite()) return 0;
  Scene scene(points, n);
  Eigen::Matrix3d h;
  if (!FindDominantPlane(scene, normalized, set, size, limit, &rng, &h)) return 0;
  Eigen::VectorXd errors;
  if (!FitPlane(&scene, kPlaneFactor * limit, &h, &errors, fits)) return 0;
  SignPlane(scene, errors, kPlaneFactor * limit, &h);
  OffPlane off(scene, errors, limit, rng.Fork("off_plane"));
  Eigen::Matrix3d f;
  if (!BestEpipole(scene, h, &off, &rng, &f, fits)) return 0;

  const Matrix3Parameters drawn = AsParameters(n.second.Matrix().transpose() * f * n.first.Matrix());
  if (!drawn.allFinite()) return 0;
  Matrix3Parameters refined = drawn;
  ++*fits;
  const bool moved =
      Fundamental::Refine(points, Eigen::VectorXd::Ones(points.rows()), {LossKind::kTruncated, threshold}, &refined);
  out[0] = refined;
  if (!moved || max_models < 2) return 1;
  out[1] = drawn;
  return 2;
}

}  // namespace diffsac
