#include "diffsac/geometry/focal_posterior.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "diffsac/geometry/focal_evidence.h"

namespace diffsac {
namespace {

/// The grid: steps of the prior's σ, either way up to kPriorReach, and of the likelihood's.
constexpr double kPriorStep = 0.5, kPriorReach = 3.0;
constexpr double kLocalSteps[] = {0.35, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0};
/// Of two lengths, across the direction that is least certain.
constexpr double kAcrossSteps[] = {-2.6, -1.6, -0.8, 0.0, 0.8, 1.6, 2.6};
/// Rows whose share of the posterior is below exp(this) of the greatest are the last ones.
constexpr double kNegligible = -12.0;

/// Of log f: the interval's covariance, of the posterior's.
template <class Matrix>
Matrix Widened(const Matrix& covariance, const Matrix& of_prior, double plane_share) {
  const Matrix prior = of_prior.inverse();
  // Beside a narrow prior the grid's covariance may be a little wider than it.
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(Matrix(covariance.inverse() - prior));
  const Matrix axes = solver.eigenvectors(),
               information = axes * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * axes.transpose();
  return (IntervalInformation<Matrix>(information, FloorOf(plane_share)) + prior).inverse();
}

/// deviation: the standard deviation of log f that the interval shall have.
FocalPosterior PosteriorOf(double focal, double low, double high, const FocalPrior& prior, double deviation) {
  const double wider = deviation / (0.5 * std::log(high / low));
  // Of two lengths the median along the posterior's axis may lie without a length's own interval.
  return {focal, focal * std::min(std::pow(low / focal, wider), 1.0),
          focal * std::max(std::pow(high / focal, wider), 1.0), deviation < kNarrower * prior.log_sigma, prior};
}

/// What is known of a length that the matches say nothing of.
FocalPosterior PriorAlone(const FocalPrior& prior) {
  const double spread = std::exp(prior.log_sigma);
  return {prior.focal, prior.focal / spread, prior.focal * spread, false, prior};
}

/// Where there is one length the second image's says the first one's: the same, or that it is calibrated.
LogFocals Tied(UnknownFocal unknown, LogFocals log_focals) {
  if (unknown == UnknownFocal::kBoth) log_focals[0] = log_focals[1];
  if (unknown == UnknownFocal::kSecond) log_focals[0] = 0.0;
  return log_focals;
}

FocalPosteriors Tied(UnknownFocal unknown, FocalPosteriors posteriors) {
  if (unknown == UnknownFocal::kBoth) {
    posteriors[1].correlation = 1.0;
    posteriors[0] = posteriors[1];
  }
  if (unknown == UnknownFocal::kSecond) posteriors[0] = {1.0, 1.0, 1.0, true, {1.0, 0.0}};
  return posteriors;
}

/// Where the posterior is looked at, ascending.
std::vector<double> GridOf(double centre, double deviation, double median, double prior_sigma) {
  const double reach = kPriorReach * prior_sigma;
  std::vector<double> grid = {centre};
  for (const double step : kLocalSteps)
    for (const double sign : {-1.0, 1.0}) grid.push_back(centre + sign * step * deviation);
  for (double at = -kPriorReach; at <= kPriorReach; at += kPriorStep) grid.push_back(median + at * prior_sigma);
  std::erase_if(grid, [&](double at) { return at != centre && std::abs(at - median) > reach; });
  std::sort(grid.begin(), grid.end());
  grid.erase(std::unique(grid.begin(), grid.end()), grid.end());
  return grid;
}

std::size_t PlaceOf(const std::vector<double>& grid, double centre) {
  return static_cast<std::size_t>(std::find(grid.begin(), grid.end(), centre) - grid.begin());
}

double TopOf(const std::vector<GridNode>& nodes) {
  double top = nodes.front().log_density;
  for (const GridNode& node : nodes) top = std::max(top, node.log_density);
  return top;
}

/// One unknown length: of one image, or of both.
class OneLength {
 public:
  OneLength(UnknownFocal unknown, const FocalEvidence& evidence, const FocalPrior& prior)
      : unknown_(unknown), evidence_(evidence), prior_(prior) {}

  bool operator()(const FocalParameters& best, FocalParameters* model, FocalPosteriors* out) const {
    const double centre = std::log(best[10]), deviation = std::sqrt(evidence_.Covariance(best)(0, 0));
    const std::vector<double> grid = GridOf(centre, deviation, std::log(prior_.focal), prior_.log_sigma);
    const std::size_t middle = PlaceOf(grid, centre);
    std::vector<FocalNode> nodes(grid.size());
    nodes[middle] = At(centre, best);
    for (std::size_t i = middle + 1; i < grid.size(); ++i) nodes[i] = At(grid[i], nodes[i - 1].model);
    for (std::size_t i = middle; i-- > 0;) nodes[i] = At(grid[i], nodes[i + 1].model);
    std::vector<GridNode> line(grid.size());
    for (std::size_t i = 0; i < grid.size(); ++i) line[i] = {grid[i], nodes[i].log_posterior};

    const double top = TopOf(line);
    if (!std::isfinite(top)) return false;
    const double low = QuantileOf(line, top, kTail), high = QuantileOf(line, top, 1.0 - kTail);
    const double median = QuantileOf(line, top, 0.5);
    const auto nearest = std::min_element(line.begin(), line.end(), [&](const GridNode& a, const GridNode& b) {
      return std::abs(a.at - median) < std::abs(b.at - median);
    });
    const FocalParameters chosen = At(median, nodes[static_cast<std::size_t>(nearest - line.begin())].model).model;
    if (!chosen.allFinite()) return false;
    *model = chosen;
    using Scalar = Eigen::Matrix<double, 1, 1>;
    const double half = 0.5 * (high - low);
    const double variance =
        Widened<Scalar>(Scalar(half * half), Scalar(prior_.log_sigma * prior_.log_sigma), evidence_.PlaneShare())(0, 0);
    *out = Tied(
        unknown_,
        FocalPosteriors{{{}, PosteriorOf(chosen[10], std::exp(low), std::exp(high), prior_, std::sqrt(variance))}});
    return true;
  }

 private:
  FocalNode At(double log_focal, const FocalParameters& start) const {
    return evidence_.At(Tied(unknown_, LogFocals{log_focal, log_focal}), start);
  }

  UnknownFocal unknown_;
  const FocalEvidence& evidence_;
  FocalPrior prior_;
};

/// A length for each image. The matches say much more of one combination of both logarithms than of the other: the grid
/// has rows across the direction that is least certain, each about where the one before it had its mean, so that it
/// follows a posterior that is bent.
class TwoLengths {
 public:
  TwoLengths(const FocalEvidence& evidence, const FocalPriors& priors) : evidence_(evidence), priors_(priors) {}

  bool operator()(const FocalParameters& best, FocalParameters* model, FocalPosteriors* out) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(Eigen::Matrix2d(evidence_.Covariance(best)));
    if (axes.info() != Eigen::Success || !(axes.eigenvalues()[0] > 0.0)) return false;
    along_ = axes.eigenvectors().col(1);
    across_ = axes.eigenvectors().col(0);
    across_sigma_ = std::sqrt(axes.eigenvalues()[0]);
    const Eigen::Vector2d centre(std::log(best[9]), std::log(best[10])), median = Medians();
    // The prior's, in the direction of least certainty.
    const double prior_sigma = std::hypot(along_[0] * priors_[0].log_sigma, along_[1] * priors_[1].log_sigma);
    std::vector<double> grid =
        GridOf(along_.dot(centre), std::sqrt(axes.eigenvalues()[1]), along_.dot(median), prior_sigma);
    const std::size_t middle = PlaceOf(grid, along_.dot(centre));
    rows_.resize(grid.size());
    rows_[middle] = RowAt(grid[middle], across_.dot(centre), best);
    const auto matters = [&](const Row& row) { return row.log_mass - rows_[middle].log_mass > kNegligible; };
    std::size_t first = middle, last = middle;
    for (; last + 1 < grid.size() && matters(rows_[last]); ++last) rows_[last + 1] = RowAt(grid[last + 1], rows_[last]);
    for (; first > 0 && matters(rows_[first]); --first) rows_[first - 1] = RowAt(grid[first - 1], rows_[first]);
    grid = {grid.begin() + static_cast<std::ptrdiff_t>(first), grid.begin() + static_cast<std::ptrdiff_t>(last) + 1};
    rows_ = {rows_.begin() + static_cast<std::ptrdiff_t>(first), rows_.begin() + static_cast<std::ptrdiff_t>(last) + 1};
    return grid.size() > 1 && Choose(grid, model, out);
  }

 private:
  struct Row {
    std::vector<GridNode> nodes;  ///< Across.
    double log_mass = 0.0;        ///< log of the posterior's integral across.
    double mean = 0.0;            ///< Across.
    FocalParameters model;        ///< Of its likeliest node.
  };

  Eigen::Vector2d Medians() const { return {std::log(priors_[0].focal), std::log(priors_[1].focal)}; }
  LogFocals Place(double along, double across) const {
    const Eigen::Vector2d at = along * along_ + across * across_;
    return {at[0], at[1]};
  }
  Row RowAt(double along, const Row& beside) const { return RowAt(along, beside.mean, beside.model); }

  Row RowAt(double along, double across, const FocalParameters& start) const {
    Row row;
    row.model = start;
    double top = -std::numeric_limits<double>::infinity(), mass = 0.0, sum = 0.0;
    for (const double step : kAcrossSteps) {
      const FocalNode node = evidence_.At(Place(along, across + step * across_sigma_), row.model);
      row.nodes.push_back({across + step * across_sigma_, node.log_posterior});
      if (!(node.log_posterior > top)) continue;
      top = node.log_posterior;
      row.model = node.model;
    }
    for (std::size_t i = 0; i < row.nodes.size(); ++i) {
      const double weight = WidthOf(row.nodes, i) * std::exp(row.nodes[i].log_density - top);
      mass += weight;
      sum += weight * row.nodes[i].at;
    }
    row.log_mass = top + std::log(mass);
    row.mean = sum / mass;
    return row;
  }

  static double WidthOf(const std::vector<GridNode>& nodes, std::size_t i) {
    const double left = nodes[i == 0 ? 0 : i - 1].at, right = nodes[std::min(i + 1, nodes.size() - 1)].at;
    return 0.5 * (right - left);
  }

  bool Choose(const std::vector<double>& grid, FocalParameters* model, FocalPosteriors* out) const {
    std::vector<GridNode> line(grid.size());
    for (std::size_t i = 0; i < grid.size(); ++i) line[i] = {grid[i], rows_[i].log_mass};
    const double top = TopOf(line);
    if (!std::isfinite(top)) return false;
    const double along = QuantileOf(line, top, 0.5);
    // Between the means of the rows on either side.
    const auto above = std::upper_bound(grid.begin(), grid.end(), along);
    const std::size_t right =
        std::clamp<std::size_t>(static_cast<std::size_t>(above - grid.begin()), 1, grid.size() - 1);
    const double share = (along - grid[right - 1]) / (grid[right] - grid[right - 1]);
    const double across = rows_[right - 1].mean + share * (rows_[right].mean - rows_[right - 1].mean);
    const Row& nearest = rows_[share < 0.5 ? right - 1 : right];
    const FocalParameters chosen = evidence_.At(Place(along, across), nearest.model).model;
    if (!chosen.allFinite()) return false;
    *model = chosen;
    Eigen::Vector2d low, high;
    for (int k = 0; k < 2; ++k) {
      const Masses masses = MassesOf(line, top, k);
      low[k] = Quantile(masses, kTail);
      high[k] = Quantile(masses, 1.0 - kTail);
    }
    const Eigen::Vector2d half = 0.5 * (high - low), prior(priors_[0].log_sigma, priors_[1].log_sigma);
    Eigen::Matrix2d covariance = half.cwiseAbs2().asDiagonal();
    covariance(0, 1) = covariance(1, 0) = Correlation(line, top) * half.prod();
    const Eigen::Matrix2d wide =
        Widened<Eigen::Matrix2d>(covariance, Eigen::Matrix2d(prior.cwiseAbs2().asDiagonal()), evidence_.PlaneShare());
    const Eigen::Vector2d deviations = wide.diagonal().cwiseSqrt();
    if (!deviations.allFinite()) return false;
    for (int k = 0; k < 2; ++k) {
      (*out)[k] = PosteriorOf(chosen[9 + k], std::exp(low[k]), std::exp(high[k]), priors_[k], deviations[k]);
      (*out)[k].correlation = std::clamp(wide(0, 1) / deviations.prod(), -1.0, 1.0);
    }
    return true;
  }

  /// Calls visit(log f of both, mass) with each node.
  template <class Visit>
  void ForEachNode(const std::vector<GridNode>& line, double top, const Visit& visit) const {
    for (std::size_t i = 0; i < rows_.size(); ++i)
      for (std::size_t j = 0; j < rows_[i].nodes.size(); ++j) {
        const GridNode& node = rows_[i].nodes[j];
        visit(Place(line[i].at, node.at),
              WidthOf(line, i) * WidthOf(rows_[i].nodes, j) * std::exp(node.log_density - top));
      }
  }

  double Correlation(const std::vector<GridNode>& line, double top) const {
    const Eigen::Vector2d centre = Medians();
    double total = 0.0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    ForEachNode(line, top, [&](const LogFocals& place, double mass) {
      const Eigen::Vector2d at(place[0] - centre[0], place[1] - centre[1]);
      total += mass;
      mean += mass * at;
      squares += mass * at * at.transpose();
    });
    mean /= total;
    const Eigen::Matrix2d covariance = squares / total - mean * mean.transpose();
    const double scale = std::sqrt(covariance(0, 0) * covariance(1, 1));
    return scale > 0.0 ? std::clamp(covariance(0, 1) / scale, -1.0, 1.0) : 0.0;
  }

  /// Of one length: log f of each node, ascending, and its mass.
  struct Masses {
    std::vector<std::pair<double, double>> places;
    double total = 0.0;
  };
  Masses MassesOf(const std::vector<GridNode>& line, double top, int image) const {
    Masses masses;
    ForEachNode(line, top, [&](const LogFocals& place, double mass) {
      masses.places.emplace_back(place[image], mass);
      masses.total += mass;
    });
    std::sort(masses.places.begin(), masses.places.end());
    return masses;
  }

  /// Below where such a share of the posterior lies.
  static double Quantile(const Masses& masses, double share) {
    const auto& [places, total] = masses;
    // Each mass lies half before and half behind its place.
    double below = 0.0, last_at = places.front().first, last_share = 0.0;
    for (const auto& [at, mass] : places) {
      const double until = (below + 0.5 * mass) / total;
      if (until >= share && until > last_share)
        return last_at + (share - last_share) / (until - last_share) * (at - last_at);
      below += mass;
      last_at = at;
      last_share = until;
    }
    return places.back().first;
  }

  const FocalEvidence& evidence_;
  FocalPriors priors_;
  Eigen::Vector2d along_, across_;
  double across_sigma_ = 0.0;
  std::vector<Row> rows_;
};

}  // namespace

bool MarginaliseFocal(UnknownFocal unknown, const PointMatrix& points, const Eigen::VectorXd& weights,
                      const RobustLoss& loss, const FocalPriors& priors, FocalParameters* model, FocalPosteriors* out) {
  for (int k = 2 - CountFocals(unknown); k < 2; ++k)
    if (!(priors[k].log_sigma > 0.0) || !(priors[k].focal > 0.0)) return false;
  if (!model->allFinite() || !((*model)[9] > 0.0) || !((*model)[10] > 0.0)) return false;
  FocalEvidence evidence(unknown, points, weights, loss, priors);
  FocalParameters best = *model;
  if (!evidence.Select(best) || !evidence.Refine(&best)) return false;

  if (evidence.PlaneShare() >= kOneSurface) {
    *model = evidence.At(Tied(unknown, LogFocals{std::log(priors[0].focal), std::log(priors[1].focal)}), best).model;
    *out = Tied(unknown, FocalPosteriors{PriorAlone(priors[0]), PriorAlone(priors[1])});
    return model->allFinite();
  }
  if (unknown == UnknownFocal::kEach) return TwoLengths(evidence, priors)(best, model, out);
  return OneLength(unknown, evidence, priors[1])(best, model, out);
}

}  // namespace diffsac
