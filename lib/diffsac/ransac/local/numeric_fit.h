#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "diffsac/geometry/levenberg_marquardt.h"
#include "diffsac/geometry/points.h"
#include "diffsac/geometry/robust_loss.h"

namespace diffsac {

/// Σ w ρ(r²) of a model by Levenberg-Marquardt, its derivatives by central differences of `Residual`: for models of
/// which every vector of parameters is one. Borrows points and weights; points of weight 0 cost nothing.
template <class Model>
class NumericFit {
 public:
  using Parameters = typename Model::Parameters;
  static constexpr int kFreedom = Parameters::SizeAtCompileTime;
  using Matrix = Eigen::Matrix<double, kFreedom, kFreedom>;

  NumericFit(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss)
      : points_(points), weights_(weights), loss_(loss) {}

  /// False, leaving *model, where no step lowers the cost.
  bool Minimize(int steps, Parameters* model) {
    const LevenbergResult result = diffsac::Minimize(*this, {.steps = steps, .tolerance = 1e-9}, model);
    return result.moved && model->allFinite();
  }

  // What diffsac::Minimize asks for.
  double Cost(const Parameters& model) const {
    double cost = 0.0;
    ForEachPoint([&](const double* point, double weight) {
      const double residual = Model::Residual(model, point);
      cost += weight * loss_.Value(residual * residual);
    });
    return cost;
  }

  void Linearize(const Parameters& model, Matrix* normal, Parameters* gradient) const {
    normal->setZero();
    gradient->setZero();
    ForEachPoint([&](const double* point, double weight) {
      const double residual = Model::Residual(model, point), pull = weight * loss_.Weight(residual * residual);
      if (pull == 0.0) return;
      const Parameters slope = Slope(model, point);
      if (!slope.allFinite()) return;
      *normal += pull * slope * slope.transpose();
      *gradient += pull * residual * slope;
    });
  }

  static Parameters Solve(const Matrix& damped, const Parameters& right) { return damped.ldlt().solve(right); }
  static Parameters Retract(const Parameters& model, const Parameters& step) { return model + step; }

 private:
  template <class Visit>
  void ForEachPoint(const Visit& visit) const {
    for (Eigen::Index i = 0; i < points_.rows(); ++i)
      if (weights_[i] > 0.0) visit(points_.data() + i * points_.cols(), weights_[i]);
  }

  /// d Residual / d parameters. A step is the cube root of the rounding error of a parameter's size, which for small
  /// ones is a hundredth of the largest one's.
  static Parameters Slope(const Parameters& model, const double* point) {
    constexpr double kStep = 6e-6, kSmall = 1e-2;
    const double least = std::max(kSmall * model.cwiseAbs().maxCoeff(), 1e-9);
    Parameters slope, moved = model;
    for (int j = 0; j < kFreedom; ++j) {
      const double step = kStep * std::max(std::abs(model[j]), least);
      moved[j] = model[j] + step;
      const double above = Model::Residual(moved, point);
      moved[j] = model[j] - step;
      slope[j] = (above - Model::Residual(moved, point)) / (2.0 * step);
      moved[j] = model[j];
    }
    return slope;
  }

  const PointMatrix& points_;
  const Eigen::VectorXd& weights_;
  RobustLoss loss_;
};

}  // namespace diffsac
