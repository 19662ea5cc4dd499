#pragma once

#include <memory>

namespace diffsac {

/// How a hypothesis is judged; larger is better, never negative. One header each, which has its definition:
///   kInlierCount      inlier_count.h: residuals within ε; the paper's default
///   kMsac             msac.h
///   kMlesac  mlesac.h: an inlier is Gaussian with σ, an outlier uniform
///   kMagsac           magsac.h: the loss of MAGSAC++
///   kSigmaMarginalisedMsac sigma_marginalised_msac.h: MSAC over all scales
enum class ScoreKind { kInlierCount, kMsac, kMlesac, kMagsac, kSigmaMarginalisedMsac };

/// The constants of one problem, of which each score takes its own; lengths are linear.
struct ScoreSetting {
  double threshold = 1.0;  ///< ε
  double sigma = 1.0;      ///< Of an inlier's noise.
  double odds = 1.0;       ///< Of an inlier's density to an outlier's at r = 0.
  int residual_dof = 1;    ///< 1 … 6
  double least = 0.0;      ///< The smallest scale ...
  double greatest = 1.0;   ///< ... and the greatest.
};

/// One score with its constants worked out once: a sum over points, each within [0, 1]. Its header has operator() and
/// Derivative, and Sum and UpperBound where they can be quicker than point by point.
class ScoreFunction {
 public:
  virtual ~ScoreFunction() = default;
  /// The contribution of one residual (linear), in [0, 1], never increasing in r; 0 for NaN.
  virtual double operator()(double residual) const = 0;
  /// d/dr of it, ≤ 0; 0 where it jumps.
  virtual double Derivative(double residual) const = 0;
  /// The sum over `count` residuals, times weights unless null: the hot loop's form.
  virtual double Sum(const double* residuals, const double* weights, int count) const;
  /// Whether there is a quick UpperBound.
  virtual bool HasUpperBound() const { return false; }
  /// At least the sum of contributions (times weights, unless null) of residuals whose squares, in squares of unit(),
  /// are at least these; count ≤ kBoundBlock. In single precision. Throws Error without HasUpperBound().
  virtual double UpperBound(const float* squares, const float* weights, int count) const;
  /// What residuals are measured in for bounds. Residuals beyond it all contribute alike.
  virtual double unit() const = 0;
};

/// A score by its name, to be copied and passed on.
class Score {
 public:
  Score(ScoreKind kind, const ScoreSetting& setting);
  /// greatest: threshold.
  Score(ScoreKind kind, double threshold, double sigma, double odds, int residual_dof = 1, double least = 0.0)
      : Score(kind, {threshold, sigma, odds, residual_dof, least, threshold}) {}
  ScoreKind kind() const { return kind_; }
  double threshold() const { return threshold_; }

  // As ScoreFunction has them.
  double operator()(double residual) const { return (*function_)(residual); }
  double Derivative(double residual) const { return function_->Derivative(residual); }
  double Sum(const double* residuals, int count) const { return function_->Sum(residuals, nullptr, count); }
  double Sum(const double* residuals, const double* weights, int count) const {
    return function_->Sum(residuals, weights, count);
  }
  bool HasUpperBound() const { return function_->HasUpperBound(); }
  double UpperBound(const float* squares, const float* weights, int count) const {
    return function_->UpperBound(squares, weights, count);
  }
  double unit() const { return function_->unit(); }

 private:
  ScoreKind kind_;
  double threshold_;
  std::shared_ptr<const ScoreFunction> function_;
};

}  // namespace diffsac
