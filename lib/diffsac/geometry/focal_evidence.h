#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "diffsac/geometry/focal.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/geometry/robust_loss.h"
#include "diffsac/geometry/unknown_focal.h"

namespace diffsac {

/// A homography that this share of the points follows explains them.
inline constexpr double kOneSurface = 0.9;

/// log f of either image.
using LogFocals = std::array<double, 2>;

/// E refined at focal lengths that are held.
struct FocalNode {
  FocalParameters model;
  double log_posterior = 0.0;
};

/// Of MarginaliseFocal: the points that take part, and what weighs a model of them.
class FocalEvidence {
 public:
  FocalEvidence(UnknownFocal unknown, const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                const FocalPriors& priors);

  /// Leaves out what is far from the model.
  bool Select(const FocalParameters& model);
  /// Refines the focal lengths too, and takes κ and PlaneShare from what is left.
  bool Refine(FocalParameters* model);
  /// How many of the points a homography explains: those of a plane, or of a pure rotation, leave E and f open
  /// together.
  double PlaneShare() const { return plane_share_; }
  /// κ, of matches whose errors go together.
  double variance() const { return variance_; }
  FocalNode At(const LogFocals& log_focals, const FocalParameters& start) const;
  /// The covariance of log f (of both images, or where there is one length its variance) that matches and priors leave,
  /// to second order.
  Eigen::MatrixXd Covariance(const FocalParameters& model) const;

 private:
  int Free() const { return 5 + CountFocals(unknown_); }
  int Size() const { return static_cast<int>(weights_.size()); }
  std::array<const double*, 4> Columns() const {
    return {columns_.col(0).data(), columns_.col(1).data(), columns_.col(2).data(), columns_.col(3).data()};
  }
  Eigen::VectorXd Distances(const FocalParameters& model) const;
  double FindPlaneShare() const;
  template <UnknownFocal kUnknown>
  Eigen::MatrixXd InformationOn(const FocalParameters& model) const;

  UnknownFocal unknown_;
  RobustLoss loss_;
  FocalPriors priors_;
  RefineOptions options_;
  PointMatrix points_;
  Eigen::VectorXd weights_;
  Eigen::Matrix<double, Eigen::Dynamic, 4> columns_;  ///< The points, by coordinate.
  double variance_ = 0.0, plane_share_ = 0.0;
};

/// The posterior between two nodes of a grid is exponential.
struct GridNode {
  double at = 0.0, log_density = 0.0;
};
/// Below where such a share of the posterior lies. Nodes ascend; top: their highest log_density.
double QuantileOf(const std::vector<GridNode>& nodes, double top, double share);

/// Tails of a normal distribution outside one σ.
inline constexpr double kTail = 0.15865525393145707;

}  // namespace diffsac
