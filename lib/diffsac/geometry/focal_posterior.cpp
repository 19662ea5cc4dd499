#include "diffsac/geometry/focal_posterior.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/manifolds.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/geometry/robust_loss_sums.h"
#include "diffsac/geometry/sampson_equations.h"

namespace diffsac {
namespace {

/// The grid: steps of the prior's σ, either way up to kPriorReach, and of the likelihood's.
constexpr double kPriorStep = 0.5, kPriorReach = 3.0;
constexpr double kLocalSteps[] = {0.35, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0};
/// A homography that this share of the points follows, within so many standard deviations of a Sampson distance
/// (transfer errors have twice that), explains them.
constexpr double kOneSurface = 0.9, kSurfaceSigmas = 5.0;
/// Errors of matches in photographs go together (lens distortion, principal points that are off, keypoints of one
/// edge), so that each says what this share of an independent one would. Chosen on the tuning scenes
/// (docs/two_view.md).
constexpr double kIndependentShare = 0.25;
/// Tails of a normal distribution outside one σ.
constexpr double kTail = 0.15865525393145707;

/// E refined at one focal length.
struct Node {
  double log_focal = 0.0;
  FocalParameters model;
  double log_posterior = 0.0;
};

/// The points that take part, and what weighs a model of them.
class Evidence {
 public:
  Evidence(UnknownFocal unknown, const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
           const FocalPrior& prior)
      : unknown_(unknown), loss_(loss), prior_(prior) {
    options_.loss = loss;
    options_.relative_tolerance = 1e-6;
    points_ = points;
    weights_ = weights;
  }

  /// Leaves out what is far from the model.
  bool Select(const FocalParameters& model) {
    std::vector<int> near;
    const Matrix3Parameters f = FundamentalOf(unknown_, model);
    for (int i = 0; i < points_.rows(); ++i)
      if (weights_[i] > 0.0 && SampsonError(f, points_.row(i).data()) <= kRefineReach * loss_.scale) near.push_back(i);
    points_ = points_(near, Eigen::all).eval();
    weights_ = weights_(near).eval();
    columns_ = points_;
    return static_cast<int>(near.size()) > kFree;
  }

  /// Refines f too, and takes κ from what is left.
  bool Refine(FocalParameters* model) {
    if (RefineFocal(unknown_, points_, weights_, options_, prior_, model).status != Status::kOk) return false;
    const Eigen::VectorXd distances = Distances(*model);
    variance_ = ResidualVariance(loss_, distances.data(), weights_.data(), Size(), kFree) / kIndependentShare;
    return variance_ > 0.0 && model->allFinite();
  }

  /// Whether a homography explains the points: a plane, or a turn in place, which leave E and f open together.
  bool OnOneSurface() const {
    constexpr int kRounds = 3;
    const double sigma = std::sqrt(kIndependentShare * variance_);
    const double reach = std::max(kSurfaceSigmas * sigma, loss_.least);
    Eigen::VectorXd explained = weights_;
    for (int round = 0; round < kRounds; ++round) {
      Matrix3Parameters h;
      if (!Homography::Fit(points_, explained, &h)) return false;
      for (int i = 0; i < Size(); ++i)
        explained[i] = SymmetricTransferError(h, points_.row(i).data()) <= reach ? weights_[i] : 0.0;
    }
    return explained.sum() >= kOneSurface * weights_.sum();
  }

  Node At(double log_focal, const FocalParameters& start) const {
    Node node{log_focal, start, 0.0};
    node.model[9] = std::exp(log_focal);
    // The points that were near go out of the loss's reach together, and nothing would pull them back.
    RefineOptions far_reaching = options_;
    far_reaching.loss = {LossKind::kHuber, loss_.scale};
    RefineWithFocal(unknown_, points_, weights_, far_reaching, &node.model);
    RefineWithFocal(unknown_, points_, weights_, options_, &node.model);
    const double cost = SumLoss(loss_, Distances(node.model).data(), weights_.data(), Size());
    const double deviation = (log_focal - std::log(prior_.focal)) / prior_.log_sigma;
    node.log_posterior = -0.5 * (cost / variance_ + deviation * deviation);
    return node;
  }

  /// The standard deviation of log f that matches and prior leave it, to second order.
  double Deviation(const FocalParameters& model) const {
    const Eigen::Matrix<double, 6, 6> information = unknown_ == UnknownFocal::kBoth
                                                        ? InformationOn<UnknownFocal::kBoth>(model)
                                                        : InformationOn<UnknownFocal::kSecond>(model);
    const Eigen::Matrix<double, 6, 1> last = Eigen::Matrix<double, 6, 1>::Unit(5);
    const double variance = variance_ * last.dot(information.ldlt().solve(last));
    const double by_matches = variance > 0.0 && std::isfinite(variance) ? 1.0 / variance : 0.0;
    return 1.0 / std::sqrt(by_matches + 1.0 / (prior_.log_sigma * prior_.log_sigma));
  }

 private:
  static constexpr int kFree = 6;

  int Size() const { return static_cast<int>(weights_.size()); }

  std::array<const double*, 4> Columns() const {
    return {columns_.col(0).data(), columns_.col(1).data(), columns_.col(2).data(), columns_.col(3).data()};
  }

  Eigen::VectorXd Distances(const FocalParameters& model) const {
    Eigen::VectorXd distances(Size());
    SampsonDistances(FundamentalOf(unknown_, model).data(), Columns().data(), 0, Size(), distances.data());
    return distances;
  }

  /// Of E and log f, before κ.
  template <UnknownFocal kUnknown>
  Eigen::Matrix<double, 6, 6> InformationOn(const FocalParameters& model) const {
    using Manifold = FocalManifold<kUnknown, false>;
    const Manifold state = Manifold::From(model);
    const Eigen::VectorXd distances = Distances(model);
    Eigen::VectorXd pulls(Size());
    LossWeights(loss_, distances.data(), weights_.data(), Size(), pulls.data());
    const auto equations = SumSampsonEquations(state.Parameters().data(), Columns().data(), pulls.data(), Size());
    const typename Manifold::TangentMatrix tangent = state.Tangent();
    return tangent.transpose() * equations.normal * tangent;
  }

  UnknownFocal unknown_;
  RobustLoss loss_;
  FocalPrior prior_;
  RefineOptions options_;
  PointMatrix points_;
  Eigen::VectorXd weights_;
  Eigen::Matrix<double, Eigen::Dynamic, 4> columns_;  ///< The points, by coordinate.
  double variance_ = 0.0;                             ///< κ, of matches whose errors go together.
};

/// Where the posterior is looked at, ascending.
std::vector<double> GridOf(double centre, double deviation, const FocalPrior& prior) {
  const double median = std::log(prior.focal), reach = kPriorReach * prior.log_sigma;
  std::vector<double> grid = {centre};
  for (const double step : kLocalSteps)
    for (const double sign : {-1.0, 1.0}) grid.push_back(centre + sign * step * deviation);
  for (double at = -kPriorReach; at <= kPriorReach; at += kPriorStep) grid.push_back(median + at * prior.log_sigma);
  std::erase_if(grid, [&](double at) { return at != centre && std::abs(at - median) > reach; });
  std::sort(grid.begin(), grid.end());
  grid.erase(std::unique(grid.begin(), grid.end()), grid.end());
  return grid;
}

/// The posterior between two nodes is exponential: its mass up to a share of the way, and all of it with share = 1.
double MassUpTo(const Node& left, const Node& right, double top, double share) {
  const double width = share * (right.log_focal - left.log_focal);
  const double rise = share * (right.log_posterior - left.log_posterior);
  // From the higher end, so that nothing overflows.
  const double height = std::exp(left.log_posterior + std::max(0.0, rise) - top), fall = std::abs(rise);
  return width * height * (fall < 1e-9 ? 1.0 : -std::expm1(-fall) / fall);
}

/// log f below which so much of the posterior lies.
double Quantile(const std::vector<Node>& nodes, double top, double share) {
  double total = 0.0;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) total += MassUpTo(nodes[i], nodes[i + 1], top, 1.0);
  double left = share * total;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const double mass = MassUpTo(nodes[i], nodes[i + 1], top, 1.0);
    if (left > mass) {
      left -= mass;
      continue;
    }
    double low = 0.0, high = 1.0;
    for (int step = 0; step < 40; ++step) {
      const double middle = 0.5 * (low + high);
      (MassUpTo(nodes[i], nodes[i + 1], top, middle) < left ? low : high) = middle;
    }
    return nodes[i].log_focal + low * (nodes[i + 1].log_focal - nodes[i].log_focal);
  }
  return nodes.back().log_focal;
}

}  // namespace

bool MarginaliseFocal(UnknownFocal unknown, const PointMatrix& points, const Eigen::VectorXd& weights,
                      const RobustLoss& loss, const FocalPrior& prior, FocalParameters* model, FocalPosterior* out) {
  if (!(prior.log_sigma > 0.0) || !(prior.focal > 0.0) || !model->allFinite() || !((*model)[9] > 0.0)) return false;
  Evidence evidence(unknown, points, weights, loss, prior);
  FocalParameters best = *model;
  if (!evidence.Select(best) || !evidence.Refine(&best)) return false;

  if (evidence.OnOneSurface()) {
    const double spread = std::exp(prior.log_sigma);
    *model = evidence.At(std::log(prior.focal), best).model;
    *out = {prior.focal, prior.focal / spread, prior.focal * spread, false, prior};
    return model->allFinite();
  }

  const double centre = std::log(best[9]);
  const std::vector<double> grid = GridOf(centre, evidence.Deviation(best), prior);
  const auto middle = static_cast<std::size_t>(std::find(grid.begin(), grid.end(), centre) - grid.begin());
  std::vector<Node> nodes(grid.size());
  nodes[middle] = evidence.At(centre, best);
  for (std::size_t i = middle + 1; i < grid.size(); ++i) nodes[i] = evidence.At(grid[i], nodes[i - 1].model);
  for (std::size_t i = middle; i-- > 0;) nodes[i] = evidence.At(grid[i], nodes[i + 1].model);

  double top = nodes.front().log_posterior;
  for (const Node& node : nodes) top = std::max(top, node.log_posterior);
  if (!std::isfinite(top)) return false;
  const double low = Quantile(nodes, top, kTail), high = Quantile(nodes, top, 1.0 - kTail);
  const double median = Quantile(nodes, top, 0.5);
  const auto distance = [&](const Node& node) { return std::abs(node.log_focal - median); };
  const auto nearest = std::min_element(nodes.begin(), nodes.end(),
                                        [&](const Node& a, const Node& b) { return distance(a) < distance(b); });
  const FocalParameters chosen = evidence.At(median, nearest->model).model;
  if (!chosen.allFinite()) return false;
  *model = chosen;
  *out = {chosen[9], std::exp(low), std::exp(high), high - low < 2.0 * kNarrower * prior.log_sigma, prior};
  return true;
}

}  // namespace diffsac
