#include <opencv2/calib3d.hpp>
#include <vector>

#include "diffsac/estimate/task_dispatch.h"
#include "lab/baselines/opencv_usac.h"
#include "lab/config/estimator_registry.h"
#include "lab/options/options.h"

namespace diffsac {

/// OpenCV's flags: kRansac, what solvePnPRansac does without one, EPnP of 5 points in a plain loop | its USAC presets.
enum class PnpPreset {
  kRansac = cv::SOLVEPNP_ITERATIVE,
  kDefault = cv::USAC_DEFAULT,
  kAccurate = cv::USAC_ACCURATE,
  kFast = cv::USAC_FAST,
  kMagsac = cv::USAC_MAGSAC,
  kProsac = cv::USAC_PROSAC
};

template <>
inline constexpr auto kEnumNames<PnpPreset> = NamesOf<PnpPreset>({{PnpPreset::kRansac, "ransac"},
                                                                  {PnpPreset::kDefault, "default"},
                                                                  {PnpPreset::kAccurate, "accurate"},
                                                                  {PnpPreset::kFast, "fast"},
                                                                  {PnpPreset::kMagsac, "magsac"},
                                                                  {PnpPreset::kProsac, "prosac"}});

namespace {

struct OpencvPnpOptions : OpencvOptions {
  PnpPreset preset = PnpPreset::kDefault;
  void Bind(OptionsBinder& b) {
    OpencvOptions::Bind(b);
    b.Field("preset", preset).Help("OpenCV's flag; `prosac` gets the points best first, `ransac` is EPnP of 5 points");
  }
};

/// In pixels with the calibration, as its users call it.
bool SolveWithOpencv(const Problem& problem, const OpencvPnpOptions& options, AbsolutePose::Parameters* pose) {
  std::vector<cv::Point3d> scene;
  std::vector<cv::Point2d> image;
  for (const int i : OpencvOrder(problem, options.preset == PnpPreset::kProsac)) {
    const auto p = problem.points.row(i);
    scene.emplace_back(p[0], p[1], p[2]);
    image.emplace_back(p[3], p[4]);
  }
  const Eigen::Matrix3d& k = problem.cameras->K1;
  const cv::Matx33d camera(k(0, 0), k(0, 1), k(0, 2), k(1, 0), k(1, 1), k(1, 2), k(2, 0), k(2, 1), k(2, 2));
  cv::Mat turn, shift, rotation;
  std::vector<int> inliers;
  try {
    if (!cv::solvePnPRansac(scene, image, camera, cv::noArray(), turn, shift, false, options.max_iterations,
                            static_cast<float>(problem.inlier_threshold), options.confidence, inliers,
                            static_cast<int>(options.preset)))
      return false;
    cv::Rodrigues(turn, rotation);
  } catch (const cv::Exception&) {
    return false;
  }
  if (rotation.rows != 3 || shift.total() != 3) return false;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) (*pose)[4 * i + j] = rotation.at<double>(i, j);
    (*pose)[4 * i + 3] = shift.at<double>(i);
  }
  return pose->allFinite();
}

class OpencvPnp : public RobustEstimator {
 public:
  explicit OpencvPnp(const OpencvPnpOptions& options) : options_(options) {}
  Estimate DoRun(const NormalizedProblem& given, std::uint64_t /*seed*/) const override {
    return TimedEstimate(given, [&]<MinimalModel Model>(const NormalizedProblem& space) {
      Estimate estimate;
      if constexpr (std::same_as<Model, AbsolutePose>) {
        estimate.stats.hypotheses = options_.max_iterations;
        AbsolutePose::Parameters pose;
        if (SolveWithOpencv(space.problem(), options_, &pose)) AcceptModel<Model>(space, pose, &estimate);
      }
      return estimate;
    });
  }

 private:
  OpencvPnpOptions options_;
};

const RegisteredEstimator<OpencvPnpOptions> kOpencvPnp(
    "opencv_pnp", "Absolute poses: OpenCV's solvePnPRansac on the same problems.",
    [](Task task) {
      const bool suits = DispatchTask(task, []<class Model>() { return std::same_as<Model, AbsolutePose>; });
      if (!suits) throw Error("opencv_pnp estimates absolute poses only");
      return OpencvPnpOptions();
    },
    [](const OpencvPnpOptions& options) { return std::make_unique<OpencvPnp>(options); });

}  // namespace

}  // namespace diffsac
