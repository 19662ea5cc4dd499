#include "lab/images/photograph_cameras.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "diffsac/geometry/focal_posterior.h"
#include "lab/images/exif_focal.h"
#include "lab/images/image_cameras.h"
#include "lab/images/image_features.h"

namespace diffsac {
namespace {

/// Principal points that are off and lenses are the same in all pairs of a camera, so that many pairs know f no better.
constexpr double kLeastLogSigma = 0.02;
/// How many times the variance is that pairs say: the least one with which half of them agree is taken.
constexpr double kTimes[] = {1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0};
constexpr double kLeastPairSigma = 0.01;  // Of log f, of what a pair says.
constexpr double kMedianOfTwo = 1.386;    // Of χ² of two degrees of freedom.
constexpr int kRounds = 20;
/// Of Student's t, which pairs that are wrong have little weight in.
constexpr double kFreedom = 3.0;

/// What a pair says of the log f of two cameras beside its priors: normal. `cameras` are one where the length is one.
struct Say {
  std::array<int, 2> cameras;
  Eigen::Vector2d mean;
  Eigen::Matrix2d covariance;
};

/// Nothing where the pair knows no more than its priors.
std::optional<Say> SayOf(const FocalEstimate& focal, const std::array<int, 2>& cameras) {
  Eigen::Vector2d median, mean, prior, sigma, prior_sigma;
  for (int k = 0; k < 2; ++k) {
    const double low = std::log(focal.low_px[k]), high = std::log(focal.high_px[k]);
    median[k] = std::log(focal.focal_px[k]);
    mean[k] = 0.5 * (low + high);
    sigma[k] = std::max(0.5 * (high - low), 1e-3);
    prior[k] = std::log(focal.prior_focal_px[k]);
    prior_sigma[k] = focal.prior_log_sigma[k];
  }
  if (!(prior_sigma.minCoeff() > 0.0)) return std::nullopt;
  // Of one length, two that are nearly the same.
  const double correlation = std::min(focal.log_correlation, 0.999);
  Eigen::Matrix2d covariance = sigma.cwiseAbs2().asDiagonal();
  covariance(0, 1) = covariance(1, 0) = correlation * sigma[0] * sigma[1];
  Eigen::Matrix2d of_prior = prior_sigma.cwiseAbs2().asDiagonal();
  if (focal.log_correlation == 1.0) of_prior(0, 1) = of_prior(1, 0) = correlation * prior_sigma[0] * prior_sigma[1];
  const Eigen::Matrix2d prior_information = of_prior.inverse(),
                        matches = PosteriorInformation<Eigen::Matrix2d>(covariance.inverse() - prior_information),
                        posterior = matches + prior_information;
  // The interval's ends are farther from the median than the posterior's, as its deviation is wider.
  const Eigen::Vector2d narrower = posterior.inverse().diagonal().cwiseMax(0.0).cwiseSqrt().cwiseQuotient(sigma);
  mean = median + narrower.cwiseProduct(mean - median);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(0.5 * (matches + matches.transpose()));
  // A direction of which it says nothing has next to no information.
  constexpr double kLeastInformation = 1e-2;
  if (!(solver.eigenvalues()[1] > kLeastInformation)) return std::nullopt;
  const Eigen::Matrix2d information = solver.eigenvectors() *
                                      solver.eigenvalues().cwiseMax(kLeastInformation).asDiagonal() *
                                      solver.eigenvectors().transpose();
  Say say{cameras, Eigen::Vector2d::Zero(), information.inverse()};
  say.mean = say.covariance * (posterior * mean - prior_information * prior);
  return say;
}

/// All cameras' log f together.
class Pool {
 public:
  Pool(const std::vector<Say>& says, const std::vector<FocalPrior>& priors) : says_(says), priors_(priors) {}

  std::vector<FocalPrior> Solve() {
    for (const double times : kTimes) {
      Fit(times);
      std::vector<double> distances;
      for (const Say& say : says_) distances.push_back(Distance(say, times));
      const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
      std::nth_element(distances.begin(), middle, distances.end());
      if (*middle <= kMedianOfTwo) break;
    }
    const Eigen::MatrixXd covariance = information_.inverse();
    std::vector<FocalPrior> pooled;
    for (std::size_t i = 0; i < priors_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      pooled.push_back({std::exp(logs_[row]), std::max(kLeastLogSigma, std::sqrt(covariance(row, row)))});
    }
    return pooled;
  }

 private:
  Eigen::Vector2d At(const Say& say) const { return {logs_[say.cameras[0]], logs_[say.cameras[1]]}; }

  static Eigen::Matrix2d InformationOf(const Say& say, double times) {
    return (times * say.covariance + kLeastPairSigma * kLeastPairSigma * Eigen::Matrix2d::Identity()).inverse();
  }

  double Distance(const Say& say, double times) const {
    const Eigen::Vector2d off = At(say) - say.mean;
    return off.dot(InformationOf(say, times) * off);
  }

  void Fit(double times) {
    const auto count = static_cast<Eigen::Index>(priors_.size());
    Eigen::VectorXd medians(count), precisions(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const FocalPrior& prior = priors_[static_cast<std::size_t>(i)];
      medians[i] = std::log(prior.focal);
      precisions[i] = 1.0 / (prior.log_sigma * prior.log_sigma);
    }
    if (logs_.size() != count) logs_ = medians;
    for (int round = 0; round < kRounds; ++round) {
      information_ = precisions.asDiagonal();
      Eigen::VectorXd right = precisions.cwiseProduct(medians);
      for (const Say& say : says_) {
        // At first all count alike: a start far off would choose among them.
        const double weight = round == 0 ? 1.0 : (kFreedom + 2.0) / (kFreedom + Distance(say, times));
        const Eigen::Matrix2d information = weight * InformationOf(say, times);
        for (int r = 0; r < 2; ++r) {
          right[say.cameras[r]] += information.row(r).dot(say.mean);
          for (int c = 0; c < 2; ++c) information_(say.cameras[r], say.cameras[c]) += information(r, c);
        }
      }
      logs_ = information_.ldlt().solve(right);
    }
  }

  const std::vector<Say>& says_;
  const std::vector<FocalPrior>& priors_;
  Eigen::VectorXd logs_;
  Eigen::MatrixXd information_;
};

}  // namespace

bool PhotographCameras::IsOne() const {
  return std::all_of(camera.begin(), camera.end(), [&](int number) { return number == camera.front(); });
}

PhotographCameras CamerasOfPhotographs(const std::vector<SourceImage>& images, const std::vector<ImageSize>& sizes,
                                       bool same) {
  PhotographCameras cameras;
  std::map<std::string, int> known;
  int count = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    std::string name = same ? "" : ExifCamera(images[i].path);
    const bool is_known = same || !name.empty();
    // Turned by a quarter it is the same; reduced it has another focal length.
    if (!sizes.empty())
      name += SizeText({std::max(sizes[i].width, sizes[i].height), std::min(sizes[i].width, sizes[i].height)});
    const auto [found, is_new] = is_known ? known.try_emplace(name, count) : std::pair(known.end(), true);
    cameras.camera.push_back(is_new ? count++ : found->second);
    cameras.hints.push_back(sizes.empty() ? CameraHint{} : ExifHint(images[i].path, sizes[i]));
    cameras.from.push_back(cameras.hints.back().focal ? FocalSource::kExif : FocalSource::kPrior);
  }
  return cameras;
}

void PoolFocals(const std::vector<std::array<int, 2>>& images, const std::vector<Estimate>& estimates,
                PhotographCameras* cameras) {
  std::vector<Say> says;
  std::map<int, FocalPrior> priors;
  std::set<int> said;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Estimate& estimate = estimates[i];
    if (!estimate.focal) continue;
    const std::array<int, 2> of = {cameras->camera[images[i][0]], cameras->camera[images[i][1]]};
    for (int k = 0; k < 2; ++k)
      priors.try_emplace(of[k], FocalPrior{estimate.focal->prior_focal_px[k], estimate.focal->prior_log_sigma[k]});
    if (estimate.MayBeChance() || IsUndetermined(estimate.translation)) continue;
    if (const auto say = SayOf(*estimate.focal, of)) {
      says.push_back(*say);
      said.insert(of.begin(), of.end());
    }
  }
  if (says.empty()) return;
  std::vector<FocalPrior> by_camera(static_cast<std::size_t>(priors.rbegin()->first) + 1, FocalPrior{1.0, 1.0});
  for (const auto& [camera, prior] : priors) by_camera[static_cast<std::size_t>(camera)] = prior;
  const std::vector<FocalPrior> pooled = Pool(says, by_camera).Solve();
  for (std::size_t i = 0; i < cameras->camera.size(); ++i) {
    if (!said.contains(cameras->camera[i])) continue;
    cameras->hints[i].focal = pooled[static_cast<std::size_t>(cameras->camera[i])];
    cameras->from[i] = FocalSource::kPairs;
  }
}

FocalSource SourceOfFocal(const Problem& problem, const std::optional<FocalEstimate>& focal, int image,
                          FocalSource hint) {
  if (problem.cameras) return FocalSource::kGiven;
  return focal && focal->observable[image] ? FocalSource::kMatches : hint;
}

}  // namespace diffsac
