#include "lab/data/synthetic_two_view.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "diffsac/geometry/homography.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/virtual_views.h"

namespace diffsac {
namespace {

enum class Kind { kGeneral, kPlanar, kMixed, kForward };

// The overlap is measured on so many points.
constexpr int kOverlapSamples = 200;
// After so many tries motion and tilt shrink by the factor with every try, and later the second camera is the first.
constexpr int kFreeTries = 10;
constexpr double kShrink = 0.96;
constexpr int kOwnCameraTries = 60;
// A match off the plane is an outlier of its homography only when it is this many ε away from it.
constexpr double kOffPlaneThresholds = 3.0;
constexpr int kOffPlaneTries = 50;

// One scene and its two views.
struct Scene {
  Kind kind = Kind::kGeneral;
  VirtualPair pair;
  double near = 1.0, far = 1.0;
  VirtualPlane plane;

  double middle() const { return std::sqrt(near * far); }

  bool GeneralMatch(Rng& rng, Eigen::Vector4d* match) const {
    const Eigen::Vector3d ray = pair.first.Ray(pair.first.RandomPixel(rng));
    return ProjectIntoBoth(pair, ray * LogUniform({near, far}, rng), kLeastDepth, match);
  }

  bool PlaneMatch(Rng& rng, Eigen::Vector4d* match) const {
    return plane.Match(pair, {near, far}, pair.first.RandomPixel(rng), match);
  }

  // Of the plane, or of all space for a camera that only turns.
  Eigen::Matrix3d Homography(bool rotation_alone) const {
    if (!rotation_alone) return plane.Homography(pair);
    return pair.second.K * pair.motion.rotation * pair.first.K.inverse();
  }
};

using MatchOf = bool (Scene::*)(Rng&, Eigen::Vector4d*) const;

double Overlap(const Scene& scene, MatchOf draw, Rng rng) {
  int seen = 0;
  Eigen::Vector4d match;
  for (int i = 0; i < kOverlapSamples; ++i) seen += (scene.*draw)(rng, &match);
  return static_cast<double>(seen) / kOverlapSamples;
}

void AppendMatches(const Scene& scene, MatchOf draw, int count, Rng rng, std::vector<Eigen::Vector4d>* matches) {
  Eigen::Vector4d match;
  while (count > 0) {
    if (!(scene.*draw)(rng, &match)) continue;
    matches->push_back(match);
    --count;
  }
}

class SyntheticTwoView : public GeneratedDataset {
 public:
  SyntheticTwoView(const SyntheticTwoViewOptions& options, std::uint64_t seed)
      : GeneratedDataset(options, "synthetic_two_view_" + ToString(options.task) + "/" + options.split,
                         "two_view_" + ToString(options.task) + "/" + options.split + "/", seed),
        options_(options),
        task_(options.task) {}

  Task task() const override { return task_; }

 private:
  Example Draw(std::uint64_t /*index*/, const Rng& rng) const override {
    const PointCounts counts = options_.matches.DrawCounts(task_, rng.Fork("counts"));
    const Scene scene = DrawScene(rng);
    const ExactMatches exact = DrawMatches(scene, counts, rng);
    Example example = MakeMatches(options_.matches, task_, scene.pair, exact, counts.total, rng.Fork("matches"));
    SetTruth(scene.pair, scene.Homography(RotationAlone(scene)), &example);
    return example;
  }

  bool ForHomography() const { return task_ == Task::kHomography; }
  bool RotationAlone(const Scene& scene) const { return ForHomography() && scene.kind == Kind::kGeneral; }
  // Whether inliers are drawn from space, and from the plane.
  bool UsesSpace(const Scene& scene) const {
    return scene.kind != Kind::kPlanar && (!ForHomography() || scene.kind == Kind::kGeneral);
  }
  bool UsesPlane(const Scene& scene) const {
    return ForHomography() ? scene.kind != Kind::kGeneral : scene.kind == Kind::kPlanar || scene.kind == Kind::kMixed;
  }

  Kind DrawKind(Rng rng) const {
    double at = rng.Uniform(0.0, options_.general + options_.planar + options_.mixed + options_.forward);
    if ((at -= options_.general) < 0.0) return Kind::kGeneral;
    if ((at -= options_.planar) < 0.0) return Kind::kPlanar;
    return (at -= options_.mixed) < 0.0 ? Kind::kMixed : Kind::kForward;
  }

  Scene DrawScene(const Rng& rng) const {
    Scene scene;
    scene.kind = DrawKind(rng.Fork("kind"));
    scene.pair.first = RandomCamera(options_.cameras, rng.Fork("camera"));
    scene.pair.second = task_ == Task::kSharedFocal
                            ? scene.pair.first
                            : RandomSecondCamera(options_.cameras, scene.pair.first, rng.Fork("second_camera"));
    Rng depth = rng.Fork("depth");
    scene.far = LogUniform(options_.depth_ratio, depth);
    for (int i = 0;; ++i) {
      if (i == kOwnCameraTries) scene.pair.second = scene.pair.first;
      const double scale = std::pow(kShrink, std::max(0, i - kFreeTries));
      DrawMotion(scale, rng.Fork("motion", i), &scene);
      DrawPlane(scale, rng.Fork("plane", i), &scene);
      if (Overlaps(scene, rng.Fork("overlap", i))) return scene;
    }
  }

  void DrawMotion(double scale, Rng rng, Scene* scene) const {
    const bool forward = scene->kind == Kind::kForward;
    const Range& turn = forward ? options_.forward_rotation_deg : options_.rotation_deg;
    const double length = scale * LogUniform(options_.baseline, rng) * scene->middle();
    const Eigen::Vector3d ahead = (rng.Uniform() < 0.5 ? 1.0 : -1.0) * Eigen::Vector3d::UnitZ();
    const double cone = rng.Uniform(options_.forward_cone_deg.low, options_.forward_cone_deg.high);
    const Eigen::Vector3d centre2 = length * (forward ? Tilted(ahead, cone, rng) : RandomDirection(rng));
    const bool converging = rng.Uniform() < options_.converging;
    const Eigen::Matrix3d rotation = RandomRotation(scale * rng.Uniform(turn.low, turn.high), rng);
    if (RotationAlone(*scene)) {
      scene->pair.motion = {rotation, Eigen::Vector3d::Zero()};
      return;
    }
    const bool turned = converging && !forward;
    scene->pair.motion = MotionTo(centre2, rotation, turned ? std::optional(scene->middle()) : std::nullopt);
  }

  // Through a point on the axis, log-uniform between the nearest and the farthest depth.
  void DrawPlane(double scale, Rng rng, Scene* scene) const {
    const double tilt = scale * rng.Uniform(options_.plane_tilt_deg.low, options_.plane_tilt_deg.high);
    scene->plane.normal = Tilted(Eigen::Vector3d::UnitZ(), tilt, rng);
    scene->plane.distance = scene->plane.normal[2] * LogUniform({scene->near, scene->far}, rng);
  }

  bool Overlaps(const Scene& scene, const Rng& rng) const {
    const double least = options_.min_overlap;
    if (UsesPlane(scene) && !scene.plane.FacesBoth(scene.pair.motion)) return false;
    if (UsesPlane(scene) && Overlap(scene, &Scene::PlaneMatch, rng.Fork("plane")) < least) return false;
    const bool space = UsesSpace(scene) || scene.kind == Kind::kMixed;
    return !space || Overlap(scene, &Scene::GeneralMatch, rng.Fork("space")) >= least;
  }

  // How many of the inliers lie on the plane. Two points off it are the fewest that fix F.
  int OnPlane(const Scene& scene, int inliers, double share) const {
    if (!UsesPlane(scene)) return 0;
    if (!UsesSpace(scene)) return inliers;
    return std::clamp(static_cast<int>(std::lround(share * inliers)), 0, std::max(0, inliers - 2));
  }

  ExactMatches DrawMatches(const Scene& scene, const PointCounts& counts, const Rng& rng) const {
    Rng shares = rng.Fork("plane_share");
    const double share = shares.Uniform(options_.plane_share.low, options_.plane_share.high);
    ExactMatches exact;
    if (UsesPlane(scene)) exact.planes.push_back(scene.plane.Homography(scene.pair));
    const int on_plane = OnPlane(scene, counts.inliers, share);
    AppendMatches(scene, &Scene::PlaneMatch, on_plane, rng.Fork("plane_inliers"), &exact.inliers);
    AppendMatches(scene, &Scene::GeneralMatch, counts.inliers - on_plane, rng.Fork("space_inliers"), &exact.inliers);
    const int outliers = counts.total - counts.inliers;
    if (ForHomography() && scene.kind == Kind::kMixed)
      AppendOffPlane(scene, static_cast<int>(std::lround((1.0 - share) * outliers)), rng.Fork("off_plane"), &exact);
    const int rest = outliers - static_cast<int>(exact.others.size());
    const int displaced = DrawDisplacedCount(options_.matches, rest, rng.Fork("displaced_count"));
    AppendMatches(scene, UsesSpace(scene) ? &Scene::GeneralMatch : &Scene::PlaneMatch, displaced, rng.Fork("displaced"),
                  &exact.displaced);
    return exact;
  }

  void AppendOffPlane(const Scene& scene, int count, Rng rng, ExactMatches* exact) const {
    const Matrix3Parameters h = AsParameters(scene.Homography(false));
    const double least = kOffPlaneThresholds * options_.matches.inlier_threshold_px;
    Eigen::Vector4d match;
    for (int i = 0; i < count; ++i)
      for (int tries = 0; tries < kOffPlaneTries; ++tries) {
        if (!scene.GeneralMatch(rng, &match) || SymmetricTransferError(h, match.data()) < least) continue;
        exact->others.push_back(match);
        break;
      }
  }

  SyntheticTwoViewOptions options_;
  Task task_;
};

}  // namespace

void SyntheticTwoViewOptions::Bind(OptionsBinder& b) {
  b.Field("task", task, kTwoViewTasks).Help("what is estimated; shared_focal: one camera takes both images");
  matches.Bind(b);
  cameras.Bind(b);
  b.Field("general", general, AtLeast(0.0)).Help("weight: points anywhere in a range of depths");
  b.Field("planar", planar, AtLeast(0.0)).Help("weight: all points on one plane");
  b.Field("mixed", mixed, AtLeast(0.0)).Help("weight: a share of the points on one plane");
  b.Field("forward", forward, AtLeast(0.0)).Help("weight: general, the camera moves along its axis");
  BindStream(b);
  b.Require(general + planar + mixed + forward > 0.0, "general", "a scene kind with a weight above 0");
}

std::unique_ptr<Dataset> MakeSyntheticTwoView(const SyntheticTwoViewOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  CheckCounts(options.matches.num_points, options.task);
  return std::make_unique<SyntheticTwoView>(options, seed);
}

const RegisteredDataset<SyntheticTwoViewOptions> kSyntheticTwoView("synthetic_two_view", DataSource::kGenerated,
                                                                   "Random scenes seen by two random cameras.",
                                                                   MakeSyntheticTwoView);

}  // namespace diffsac
