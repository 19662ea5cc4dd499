// Line segments of images, as `diffsac_vanish --estimates` writes them (lab/files/segment_files.h).

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/finite_points.h"
#include "lab/data/instance_sizes.h"
#include "lab/data/pair_scenes.h"
#include "lab/files/segment_files.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

struct VanishingPointsOptions {
  std::vector<std::string> paths;
  double inlier_threshold_deg = 2.0;
  bool calibrated = false;
  double min_length_px = 0.0;

  void Bind(OptionsBinder& b) {
    b.Field("paths", paths).Help("folders of `diffsac_vanish --estimates`, or folders of them");
    b.Field("inlier_threshold_deg", inlier_threshold_deg, Limits{0.0, 90.0, true})
        .Help("ε, of the angle between a segment and the line from its middle to the vanishing point");
    b.Field("calibrated", calibrated).Help("estimators see K; else they work without one, and only errors know it");
    b.Field("min_length_px", min_length_px, AtLeast(0.0)).Help("shorter segments are left out");
    b.Require(!paths.empty(), "paths", "a list of folders");
  }
};

// A segment is labelled by the nearest true vanishing point within this angle.
constexpr double kLabelledDegrees = 2.0;

PointMatrix LongerThan(const PointMatrix& segments, double least) {
  std::vector<int> rows;
  for (int i = 0; i < static_cast<int>(segments.rows()); ++i)
    if (!((segments.row(i).tail<2>() - segments.row(i).head<2>()).norm() < least)) rows.push_back(i);
  return segments(rows, Eigen::all);
}

/// Labels each segment with the nearest true vanishing point, and makes these the truth.
void AddTruth(const ImageSegments& image, Example* example) {
  GroundTruth& truth = example->truth;
  if (image.K) truth.cameras = CameraPair{*image.K, *image.K};
  if (image.vanishing_points.empty()) return;
  for (const Eigen::Vector3d& point : image.vanishing_points)
    truth.instances.push_back(VanishingPointTask::ModelOf(point, example->problem));
  const NormalizedProblem space(example->problem);
  for (Eigen::Index i = 0; i < space.points().rows(); ++i) {
    double least = kLabelledDegrees / space.unit();
    std::int32_t label = 0;
    for (std::size_t k = 0; k < truth.instances.size(); ++k) {
      const double r = VanishingPoint::Residual(truth.instances[k], space.points().data() + 4 * i);
      if (!(r <= least)) continue;
      least = r;
      label = static_cast<std::int32_t>(k + 1);
    }
    truth.assignment.push_back(label);
  }
  // All are judged, also those that no segment is left of.
  ArrangeInstances(0, &truth);
}

class VanishingPoints : public Dataset {
 public:
  explicit VanishingPoints(const VanishingPointsOptions& options) {
    for (const SceneFolder& scene : FindScenes(options.paths, kSegmentsFile)) AddScene(scene, options);
    if (examples_.empty()) throw Error(options.paths.front() + ": there is no image");
  }
  Task task() const override { return Task::kVanishingPoint; }
  std::int64_t size() const override { return static_cast<std::int64_t>(examples_.size()); }
  Example Get(std::uint64_t index) const override { return examples_.at(index); }

 private:
  void AddScene(const SceneFolder& scene, const VanishingPointsOptions& options) {
    const std::string path = (std::filesystem::path(scene.folder) / kSegmentsFile).string();
    for (ImageSegments& image : ReadSegments(path)) {
      Example example;
      example.index = examples_.size();
      example.scene = scene.name;
      example.id = scene.name + "/" + image.name;
      example.problem.task = Task::kVanishingPoint;
      example.problem.points = LongerThan(image.segments, options.min_length_px);
      example.problem.inlier_threshold = options.inlier_threshold_deg;
      example.problem.size1 = image.size;
      if (options.calibrated && image.K) example.problem.cameras = CameraPair{*image.K, *image.K};
      example = WithFinitePoints(std::move(example), path + ":/" + image.name);
      AddTruth(image, &example);
      examples_.push_back(std::move(example));
    }
  }

  std::vector<Example> examples_;
};

const RegisteredDataset<VanishingPointsOptions> kVanishingPoints(
    "vanishing_points", DataSource::kFiles, "Line segments of images (`diffsac_vanish --estimates`).",
    [](const VanishingPointsOptions& options, std::uint64_t) { return std::make_unique<VanishingPoints>(options); });

}  // namespace
}  // namespace diffsac
