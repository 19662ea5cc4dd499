#include "diffsac/geometry/focal_evidence.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/manifolds.h"
#include "diffsac/geometry/robust_loss_sums.h"
#include "diffsac/geometry/robust_map.h"
#include "diffsac/geometry/sampson_equations.h"

namespace diffsac {
namespace {

/// A homography explains what follows it within so many standard deviations of a Sampson distance (transfer errors have
/// twice that).
constexpr double kSurfaceSigmas = 5.0;
/// Errors of matches in photographs go together (lens distortion, principal points that are off, keypoints of one
/// edge), so that each says what this share of an independent one would. Chosen on the tuning scenes
/// (docs/two_view.md).
constexpr double kIndependentShare = 0.25;

}  // namespace

FocalEvidence::FocalEvidence(UnknownFocal unknown, const PointMatrix& points, const Eigen::VectorXd& weights,
                             const RobustLoss& loss, const FocalPriors& priors)
    : unknown_(unknown), loss_(loss), priors_(priors), points_(points), weights_(weights) {
  options_.loss = loss;
  options_.relative_tolerance = 1e-6;
}

bool FocalEvidence::Select(const FocalParameters& model) {
  std::vector<int> near;
  const Matrix3Parameters f = FundamentalOf(model);
  for (int i = 0; i < points_.rows(); ++i)
    if (weights_[i] > 0.0 && SampsonError(f, points_.row(i).data()) <= kRefineReach * loss_.scale) near.push_back(i);
  points_ = points_(near, Eigen::all).eval();
  weights_ = weights_(near).eval();
  columns_ = points_;
  return static_cast<int>(near.size()) > Free();
}

bool FocalEvidence::Refine(FocalParameters* model) {
  if (RefineFocal(unknown_, points_, weights_, options_, priors_, model).status != Status::kOk) return false;
  const Eigen::VectorXd distances = Distances(*model);
  variance_ = ResidualVariance(loss_, distances.data(), weights_.data(), Size(), Free()) / kIndependentShare;
  if (!(variance_ > 0.0) || !model->allFinite()) return false;
  plane_share_ = FindPlaneShare();
  return true;
}

double FocalEvidence::FindPlaneShare() const {
  constexpr int kRounds = 3;
  const double sigma = std::sqrt(kIndependentShare * variance_);
  const double reach = std::max(kSurfaceSigmas * sigma, loss_.least);
  Eigen::Matrix3d map;
  if (!FitRobustly(points_, sigma, Extent(points_), FitHomography, &map)) return 0.0;
  Matrix3Parameters h = AsParameters(map);
  Eigen::VectorXd explained = weights_;
  for (int round = 0; round < kRounds; ++round) {
    if (round > 0 && !Homography::Fit(points_, explained, &h)) break;
    for (int i = 0; i < Size(); ++i)
      explained[i] = SymmetricTransferError(h, points_.row(i).data()) <= reach ? weights_[i] : 0.0;
  }
  return explained.sum() / weights_.sum();
}

FocalNode FocalEvidence::At(const LogFocals& log_focals, const FocalParameters& start) const {
  FocalNode node{start, 0.0};
  for (int k = 0; k < 2; ++k) node.model[9 + k] = std::exp(log_focals[k]);
  // The points that were near go out of the loss's reach together, and nothing would pull them back.
  RefineOptions far_reaching = options_;
  far_reaching.loss = {LossKind::kHuber, loss_.scale};
  RefineWithFocal(unknown_, points_, weights_, far_reaching, &node.model);
  RefineWithFocal(unknown_, points_, weights_, options_, &node.model);
  double squares = 0.0;
  for (int k = 2 - CountFocals(unknown_); k < 2; ++k) {
    const double deviation = (log_focals[k] - std::log(priors_[k].focal)) / priors_[k].log_sigma;
    squares += deviation * deviation;
  }
  const double cost = SumLoss(loss_, Distances(node.model).data(), weights_.data(), Size());
  node.log_posterior = -0.5 * (cost / variance_ + squares);
  return node;
}

Eigen::MatrixXd FocalEvidence::Covariance(const FocalParameters& model) const {
  const int focals = CountFocals(unknown_);
  const Eigen::MatrixXd information = unknown_ == UnknownFocal::kBoth     ? InformationOn<UnknownFocal::kBoth>(model)
                                      : unknown_ == UnknownFocal::kSecond ? InformationOn<UnknownFocal::kSecond>(model)
                                                                          : InformationOn<UnknownFocal::kEach>(model);
  // What is left of the lengths' when E is free (Schur complement).
  Eigen::MatrixXd of_focals = information.bottomRightCorner(focals, focals) -
                              information.bottomLeftCorner(focals, 5) *
                                  information.topLeftCorner<5, 5>().ldlt().solve(information.topRightCorner(5, focals));
  of_focals /= variance_;
  if (!of_focals.allFinite()) of_focals.setZero();
  for (int k = 0; k < focals; ++k) {
    const double sigma = priors_[2 - focals + k].log_sigma;
    of_focals(k, k) = std::max(of_focals(k, k), 0.0) + 1.0 / (sigma * sigma);
  }
  return of_focals.inverse();
}

Eigen::VectorXd FocalEvidence::Distances(const FocalParameters& model) const {
  Eigen::VectorXd distances(Size());
  SampsonDistances(FundamentalOf(model).data(), Columns().data(), 0, Size(), distances.data());
  return distances;
}

/// Of E and log f, before κ.
template <UnknownFocal kUnknown>
Eigen::MatrixXd FocalEvidence::InformationOn(const FocalParameters& model) const {
  using Manifold = FocalManifold<kUnknown, false>;
  const Manifold state = Manifold::From(model);
  const Eigen::VectorXd distances = Distances(model);
  Eigen::VectorXd pulls(Size());
  LossWeights(loss_, distances.data(), weights_.data(), Size(), pulls.data());
  const auto equations = SumSampsonEquations(state.Parameters().data(), Columns().data(), pulls.data(), Size());
  const typename Manifold::TangentMatrix tangent = state.Tangent();
  return tangent.transpose() * equations.normal * tangent;
}

namespace {

/// Its mass up to a share of the way, and all of it with share = 1.
double MassUpTo(const GridNode& left, const GridNode& right, double top, double share) {
  const double width = share * (right.at - left.at);
  const double rise = share * (right.log_density - left.log_density);
  // From the higher end, so that nothing overflows.
  const double height = std::exp(left.log_density + std::max(0.0, rise) - top), fall = std::abs(rise);
  return width * height * (fall < 1e-9 ? 1.0 : -std::expm1(-fall) / fall);
}

}  // namespace

double QuantileOf(const std::vector<GridNode>& nodes, double top, double share) {
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
    return nodes[i].at + low * (nodes[i + 1].at - nodes[i].at);
  }
  return nodes.back().at;
}

}  // namespace diffsac
