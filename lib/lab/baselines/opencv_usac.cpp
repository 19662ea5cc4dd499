#include "lab/baselines/opencv_usac.h"

#include <algorithm>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <type_traits>
#include <vector>

#include "diffsac/estimate/task_dispatch.h"
#include "lab/config/estimator_registry.h"

namespace diffsac {
namespace {

/// OpenCV 4.6 numbers pairs of matches by an int: with more of them its graph cut reads beside its memory.
constexpr int kMostInGraphCut = 46340;

static_assert(static_cast<int>(OpencvPreset::kLmeds) == cv::LMEDS &&
              static_cast<int>(OpencvPreset::kRansac) == cv::RANSAC &&
              static_cast<int>(OpencvPreset::kMagsac) == cv::USAC_MAGSAC);

/// The models that OpenCV has an estimator of, from two images.
template <class Model>
inline constexpr bool kIsOpencvs =
    std::is_same_v<Model, Homography> || std::is_same_v<Model, Fundamental> || std::is_same_v<Model, Essential>;

template <class Model>
cv::Mat RunOpencv(const cv::Mat& first, const cv::Mat& second, double threshold, int flag,
                  const OpencvUsacOptions& options) {
  cv::Mat mask;
  if constexpr (std::is_same_v<Model, Homography>)
    return cv::findHomography(first, second, flag, threshold, mask, options.max_iterations, options.confidence);
  if constexpr (std::is_same_v<Model, Fundamental>)
    return cv::findFundamentalMat(first, second, flag, threshold, options.confidence, options.max_iterations, mask);
  static_assert(kIsOpencvs<Model>);
  return cv::findEssentialMat(first, second, cv::Mat::eye(3, 3, CV_64F), flag, options.confidence, threshold,
                              options.max_iterations, mask);
}

template <MinimalModel Model>
Estimate EstimateWithOpencv(const NormalizedProblem& space, const OpencvUsacOptions& options) {
  Estimate estimate;
  estimate.stats.hypotheses = options.max_iterations;
  const std::vector<int> order = OpencvOrder(space.problem(), options.preset == OpencvPreset::kProsac);
  const int size = static_cast<int>(order.size());
  cv::Mat first(size, 2, CV_64F), second(size, 2, CV_64F);
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < 2; ++j) {
      first.at<double>(i, j) = space.points()(order[i], j);
      second.at<double>(i, j) = space.points()(order[i], j + 2);
    }
  const double threshold = options.threshold > 0.0 ? options.threshold / space.unit() : space.threshold();
  cv::Mat found;
  try {
    found = RunOpencv<Model>(first, second, threshold, static_cast<int>(options.preset), options);
  } catch (const cv::Exception&) {
    return estimate;
  }
  if (found.rows < 3 || found.cols != 3) return estimate;
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) matrix(i, j) = found.at<double>(i, j);
  if (!matrix.allFinite() || matrix.norm() == 0.0) return estimate;
  AcceptModel<Model>(space, AsParameters(matrix), &estimate);
  return estimate;
}

}  // namespace

std::vector<int> OpencvOrder(const Problem& problem, bool by_quality) {
  std::vector<int> order(problem.points.rows());
  std::iota(order.begin(), order.end(), 0);
  if (by_quality && problem.snn_ratio.size() == problem.points.rows())
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return problem.snn_ratio[a] < problem.snn_ratio[b]; });
  return order;
}

void OpencvOptions::Bind(OptionsBinder& b) {
  b.Field("max_iterations", max_iterations, AtLeast(1)).Help("OpenCV's maximum; it may stop earlier by its confidence");
  b.Field("confidence", confidence, Within(0.0, 1.0)).Help("of OpenCV's stopping rule");
}

void OpencvUsacOptions::Bind(OptionsBinder& b) {
  OpencvOptions::Bind(b);
  b.Field("threshold", threshold, AtLeast(0.0)).Help("OpenCV's, in the data's unit; 0: the inlier threshold ε");
  b.Field("preset", preset).Help("OpenCV's flag; `prosac` gets the matches best first");
}

Estimate OpencvUsacEstimator::DoRun(const NormalizedProblem& given, std::uint64_t /*seed*/) const {
  if (options_.preset == OpencvPreset::kAccurate && given.points().rows() > kMostInGraphCut) {
    Estimate refused;
    refused.status = Status::kTooManyPoints;
    return refused;
  }
  return TimedEstimate(given, [&]<MinimalModel Model>(const NormalizedProblem& space) {
    if constexpr (kIsOpencvs<Model>) return EstimateWithOpencv<Model>(space, options_);
    return Estimate{};
  });
}

namespace {

/// A row with OpenCV's preset of this name.
struct RegisteredOpencv : RegisteredEstimator<OpencvUsacOptions> {
  RegisteredOpencv(const std::string& type, OpencvPreset preset, const std::string& help)
      : RegisteredEstimator(
            type, help,
            [type, preset](Task task) {
              if (!IsTwoView(task)) throw Error(type + " estimates two-view models only");
              OpencvUsacOptions options;
              options.preset = preset;
              return options;
            },
            [](const OpencvUsacOptions& options) { return std::make_unique<OpencvUsacEstimator>(options); }) {}
};

const RegisteredOpencv kUsac("usac", OpencvPreset::kDefault, "Two views: OpenCV's USAC_DEFAULT on the same problems.");
const RegisteredOpencv kOpencvMagsac("opencv_magsac", OpencvPreset::kMagsac,
                                     "Two views: OpenCV's USAC_MAGSAC on the same problems.");

}  // namespace

}  // namespace diffsac
