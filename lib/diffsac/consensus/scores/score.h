#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>

namespace diffsac {

/// How a hypothesis is judged; larger is better, never negative. One header each, which has its definition:
///   kInlierCount         inlier_count.h: residuals within ε; the paper's default
///   kMsac                msac.h
///   kGaussianUniform     gaussian_uniform.h: an inlier is Gaussian with σ, an outlier uniform
///   kMagsac              magsac.h: the loss of MAGSAC++
///   kMarginalised        marginalised_msac.h: MSAC over all scales
///   kMarginalLikelihood  marginal_likelihood.h: of all residuals at once, σ integrated out
enum class ScoreKind { kInlierCount, kMsac, kGaussianUniform, kMagsac, kMarginalLikelihood, kMarginalised };

/// What a score may ask of the options beside ε; the keys of these act where a score asks.
struct ScoreNeeds {
  bool scales = false;      ///< least_scale, greatest_scale
  bool dof = false;         ///< residual_dof
  bool sigma = false;       ///< sigma_factor
  bool share = false;       ///< inlier_prior
  bool half_width = false;  ///< outlier_half_width, noise_prior
};
ScoreNeeds NeedsOf(ScoreKind kind);

/// What likelihoods know beside σ and ε.
struct LikelihoodSetting {
  double half_width = 1.0;   ///< a: an outlier's residual is uniform within ±a; linear.
  int dimension = 1;         ///< d, of a residual.
  int free = 0;              ///< Points that the model takes, whatever the noise: γ.
  double noise_prior = 0.0;  ///< n₀ of the marginal likelihood.
};

/// The constants of one problem, of which each score takes its own; lengths are linear.
struct ScoreSetting {
  double threshold = 1.0;  ///< ε
  double sigma = 1.0;      ///< Of an inlier's noise.
  double odds = 1.0;       ///< Of an inlier's density to an outlier's at r = 0.
  int residual_dof = 1;    ///< 1 … 6
  double least = 0.0;      ///< The smallest scale ...
  double greatest = 1.0;   ///< ... and the greatest.
  LikelihoodSetting likelihood = {};
};

/// Squared residuals by their size: four bins an octave of r², 24 octaves below the square of the unit, and one more
/// octave's worth for all that is smaller. Scores that look at all residuals at once go over its bins instead of over
/// sorted points. Weights are those of the points, 1 each where there are none.
class SquareHistogram {
 public:
  static constexpr int kBins = 96;

  /// What the points in a bin add up to.
  struct Bin {
    double weight = 0.0;   ///< Σ w
    double squares = 0.0;  ///< Σ w r², in squares of the unit.
  };

  /// The bin of a square below 1; what bounds make less than 0 is in the first.
  static int BinOf(double square) {
    if (!(square > 0.0)) return 0;
    return std::max(0, static_cast<int>(std::bit_cast<std::uint64_t>(square) >> kShift) - kFirst);
  }
  /// No square in the bin is smaller.
  static double Least(int bin) {
    return bin == 0 ? 0.0 : std::bit_cast<double>(static_cast<std::uint64_t>(bin + kFirst) << kShift);
  }

  /// Counts `count` squared residuals, in squares of the unit; those from 1 on, and what is not a number, count in
  /// total() alone. No weights: 1 each.
  template <class Real>
  void Add(const Real* squares, const Real* weights, int count) {
    for (int i = 0; i < count; ++i) {
      const double square = squares[i];
      if (!(square < 1.0)) continue;
      const double weight = weights == nullptr ? 1.0 : static_cast<double>(weights[i]);
      Bin& bin = bins_[BinOf(square)];
      bin.weight += weight;
      bin.squares += weight * square;
    }
    total_ +=
        weights == nullptr
            ? count
            : Eigen::Map<const Eigen::Array<Real, Eigen::Dynamic, 1>>(weights, count).template cast<double>().sum();
  }

  const Bin& operator[](int bin) const { return bins_[bin]; }
  /// Σ w of all that was added.
  double total() const { return total_; }

 private:
  /// Leaves the exponent and two bits of a double's mantissa.
  static constexpr int kShift = 50;
  static constexpr int kFirst = static_cast<int>(std::bit_cast<std::uint64_t>(1.0) >> kShift) - kBins;

  std::array<Bin, kBins> bins_{};
  double total_ = 0.0;
};

/// One score with its constants worked out once. Most are sums over points, each within [0, 1]; such a score has a
/// header with operator() and Derivative, and Sum and Bound where they can be quicker than point by point. Others
/// (IsSum() false) have OfAll and BoundOfAll instead.
class ScoreFunction {
 public:
  virtual ~ScoreFunction() = default;
  virtual bool IsSum() const { return true; }
  /// The contribution of one residual (linear), in [0, 1], never increasing in r; 0 for NaN.
  virtual double operator()(double residual) const;
  /// d/dr of it, ≤ 0; 0 where it jumps.
  virtual double Derivative(double residual) const;
  /// The sum over `count` residuals, times weights unless null: the hot loop's form.
  virtual double Sum(const double* residuals, const double* weights, int count) const;
  /// Whether there is a quick bound: Bound where IsSum(), BoundOfAll elsewhere.
  virtual bool HasBound() const { return false; }
  /// At least the sum of contributions (times weights, unless null) of residuals whose squares, in squares of unit(),
  /// are at least these; count ≤ kBoundBlock. In single precision.
  virtual double Bound(const float* squares, const float* weights, int count) const;
  /// Of all residuals of a model, with weights unless null. Gives up once it is known to be below `bar`, returning
  /// `bar`.
  virtual double OfAll(const double* residuals, const double* weights, int count, double bar) const;
  /// At least the score of residuals whose squares, in squares of unit(), are at least the counted ones.
  virtual double BoundOfAll(const SquareHistogram& histogram) const;
  /// What residuals are measured in for bounds: where IsSum() what beyond all count alike.
  virtual double unit() const = 0;
};

/// A score by its name, to be copied and passed on.
class Score {
 public:
  Score(ScoreKind kind, const ScoreSetting& setting);
  /// greatest: threshold.
  Score(ScoreKind kind, double threshold, double sigma, double odds, int residual_dof = 1, double least = 0.0,
        const LikelihoodSetting& likelihood = {})
      : Score(kind, {threshold, sigma, odds, residual_dof, least, threshold, likelihood}) {}
  ScoreKind kind() const { return kind_; }
  double threshold() const { return threshold_; }

  // As ScoreFunction has them.
  bool IsSum() const { return function_->IsSum(); }
  double operator()(double residual) const { return (*function_)(residual); }
  double Derivative(double residual) const { return function_->Derivative(residual); }
  double Sum(const double* residuals, int count) const { return function_->Sum(residuals, nullptr, count); }
  double Sum(const double* residuals, const double* weights, int count) const {
    return function_->Sum(residuals, weights, count);
  }
  double OfAll(const double* residuals, const double* weights, int count, double bar = 0.0) const {
    return function_->OfAll(residuals, weights, count, bar);
  }
  bool HasBound() const { return function_->HasBound(); }
  double Bound(const float* squares, const float* weights, int count) const {
    return function_->Bound(squares, weights, count);
  }
  double BoundOfAll(const SquareHistogram& histogram) const { return function_->BoundOfAll(histogram); }
  double unit() const { return function_->unit(); }

 private:
  ScoreKind kind_;
  double threshold_;
  std::shared_ptr<const ScoreFunction> function_;
};

}  // namespace diffsac
