#include "lab/images/estimate_photographs.h"

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
constexpr double kLeastLogSigma = kIntervalFloor;
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
  Eigen::Vector2d mean, prior, sigma, prior_sigma;
  for (int k = 0; k < 2; ++k) {
    sigma[k] = std::max(0.5 * std::log(focal.high_px[k] / focal.low_px[k]), 1e-3);
    mean[k] = std::log(focal.focal_px[k]);
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
  const Eigen::Matrix2d prior_information = of_prior.inverse(), matches = covariance.inverse() - prior_information;
  // A direction of which it says nothing has next to no information, and no mean of its own.
  constexpr double kLeastInformation = 1e-2;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(0.5 * (matches + matches.transpose()));
  if (!(solver.eigenvalues()[1] > kLeastInformation)) return std::nullopt;
  // The prior has pulled the median by less than the interval, which is wider than the posterior, lets it look.
  const Eigen::Vector2d pull =
      solver.eigenvectors().transpose() * prior_information * (mean - prior) / (kIntervalFactor * kIntervalFactor);
  Eigen::Vector2d variances, pulled = Eigen::Vector2d::Zero();
  for (int k = 0; k < 2; ++k) {
    const double information = solver.eigenvalues()[k];
    variances[k] = 1.0 / std::max(information, kLeastInformation);
    if (information > kLeastInformation) pulled[k] = pull[k] / information;
  }
  return Say{cameras, mean + solver.eigenvectors() * pulled,
             solver.eigenvectors() * variances.asDiagonal() * solver.eigenvectors().transpose()};
}

/// Whether two images are of one camera: log of the odds that the ratio of their lengths gives, of lengths that are
/// equal or that of two zooms. A pair may be wrong.
double LogOddsOfOne(const Say& say) {
  constexpr double kZoom = 0.3, kSame = 0.03, kWrong = 0.3, kAnything = 1.0;
  const double difference = say.mean[0] - say.mean[1];
  const double variance = say.covariance(0, 0) + say.covariance(1, 1) - 2.0 * say.covariance(0, 1);
  const auto density = [&](double more) {
    const double all = variance + more * more;
    return std::exp(-0.5 * difference * difference / all) / std::sqrt(all);
  };
  const double wrong = kWrong * density(kAnything);
  return std::log(((1.0 - kWrong) * density(kSame) + wrong) / ((1.0 - kWrong) * density(kZoom) + wrong));
}

/// What pairs say of their cameras, of those that may say something.
template <class CamerasOf>
std::vector<Say> SaysOf(const std::vector<FocalsOfPair>& pairs, const CamerasOf& cameras_of) {
  std::vector<Say> says;
  for (const FocalsOfPair& pair : pairs)
    if (const auto say = pair.counts ? SayOf(pair.focal, cameras_of(pair.images)) : std::nullopt) says.push_back(*say);
  return says;
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

  /// Of the priors. Photographs that are together were taken alike: what cameras in general have is wrong of all of
  /// them, and not known the better for each that pairs tie to the others. EXIF data err on their own.
  static Eigen::MatrixXd CovarianceOf(const Eigen::VectorXd& sigmas) {
    constexpr double kAlike = 0.7;
    const auto general = (sigmas.array() > 2.0 * kExifLogSigma).cast<double>().matrix();
    const Eigen::VectorXd common = std::sqrt(kAlike) * sigmas.cwiseProduct(general);
    Eigen::MatrixXd covariance = common * common.transpose();
    covariance.diagonal() = sigmas.cwiseAbs2();
    return covariance;
  }

  double Distance(const Say& say, double times) const {
    const Eigen::Vector2d off = At(say) - say.mean;
    return off.dot(InformationOf(say, times) * off);
  }

  void Fit(double times) {
    const auto count = static_cast<Eigen::Index>(priors_.size());
    Eigen::VectorXd medians(count), sigmas(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      medians[i] = std::log(priors_[static_cast<std::size_t>(i)].focal);
      sigmas[i] = priors_[static_cast<std::size_t>(i)].log_sigma;
    }
    const Eigen::MatrixXd of_priors = CovarianceOf(sigmas).inverse();
    if (logs_.size() != count) logs_ = medians;
    for (int round = 0; round < kRounds; ++round) {
      information_ = of_priors;
      Eigen::VectorXd right = of_priors * medians;
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
  std::map<std::string, int> known, alike;
  int count = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    std::string name = same ? "" : ExifCamera(images[i].path);
    const bool is_known = same || !name.empty();
    // Turned by a quarter it is the same; reduced it has another focal length.
    if (!sizes.empty())
      name += SizeText({std::max(sizes[i].width, sizes[i].height), std::min(sizes[i].width, sizes[i].height)});
    const auto [found, is_new] = is_known ? known.try_emplace(name, count) : std::pair(known.end(), true);
    cameras.camera.push_back(is_new ? count++ : found->second);
    cameras.hints.push_back(sizes.empty() ? CameraPriorHint{} : ExifHint(images[i].path, sizes[i]));
    cameras.from.push_back(cameras.hints.back().focal ? FocalSource::kExif : FocalSource::kPrior);
    const bool open = !is_known && !sizes.empty() && !cameras.hints.back().focal;
    cameras.alike.push_back(open ? alike.try_emplace(name, std::ssize(alike)).first->second : -1);
  }
  return cameras;
}

void JoinCameras(const std::vector<FocalsOfPair>& pairs, PhotographCameras* cameras) {
  // Most photographs of one size that are together are of one camera: 7 of 10, say.
  const double before = std::log(0.7 / 0.3);
  std::vector<int>& camera = cameras->camera;
  const auto says = SaysOf(pairs, [](const std::array<int, 2>& images) { return images; });
  while (true) {
    struct Odds {
      double sum = 0.0;
      int count = 0;
    };
    std::map<std::pair<int, int>, Odds> between;
    for (const Say& say : says) {
      const auto [i, j] = say.cameras;
      if (camera[i] == camera[j] || cameras->alike[i] < 0 || cameras->alike[i] != cameras->alike[j]) continue;
      Odds& odds = between[std::minmax(camera[i], camera[j])];
      odds.sum += LogOddsOfOne(say);
      ++odds.count;
    }
    std::erase_if(between, [&](const auto& of) { return !(of.second.sum + before > 0.0); });
    if (between.empty()) return;
    const auto& [joined, odds] = *std::max_element(between.begin(), between.end(), [](const auto& a, const auto& b) {
      return a.second.sum / a.second.count < b.second.sum / b.second.count;
    });
    std::replace(camera.begin(), camera.end(), int{joined.second}, int{joined.first});
  }
}

void PoolFocals(const std::vector<FocalsOfPair>& pairs, PhotographCameras* cameras) {
  const auto cameras_of = [&](const std::array<int, 2>& images) {
    return std::array<int, 2>{cameras->camera[images[0]], cameras->camera[images[1]]};
  };
  const std::vector<Say> says = SaysOf(pairs, cameras_of);
  if (says.empty()) return;
  std::map<int, FocalPrior> priors;
  for (const FocalsOfPair& pair : pairs)
    for (int k = 0; k < 2; ++k)
      priors.try_emplace(cameras_of(pair.images)[k],
                         FocalPrior{pair.focal.prior_focal_px[k], pair.focal.prior_log_sigma[k]});
  std::vector<FocalPrior> by_camera(static_cast<std::size_t>(priors.rbegin()->first) + 1,
                                    FocalPrior{1.0, kExifLogSigma});
  for (const auto& [camera, prior] : priors) by_camera[static_cast<std::size_t>(camera)] = prior;
  const std::vector<FocalPrior> pooled = Pool(says, by_camera).Solve();
  for (std::size_t i = 0; i < cameras->camera.size(); ++i) {
    const auto camera = static_cast<std::size_t>(cameras->camera[i]);
    // What all pairs leave open is as well left to each.
    if (!priors.contains(cameras->camera[i]) || !(pooled[camera].log_sigma < kNarrower * by_camera[camera].log_sigma))
      continue;
    cameras->hints[i].focal = pooled[camera];
    cameras->from[i] = FocalSource::kPairs;
  }
}

bool PhotographCameras::AreDivided() const {
  for (std::size_t i = 0; i < camera.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (alike[i] >= 0 && alike[i] == alike[j] && camera[i] != camera[j]) return true;
  return false;
}

}  // namespace diffsac
