#include "lab/data/synthetic_plane_views.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_registry.h"
#include "lab/data/virtual_views.h"

namespace diffsac {
namespace {

// Two planes are told apart when at most this share of the matches of either is within so many ε of the other.
constexpr double kSharedMost = 0.5;
constexpr double kSharedThresholds = 2.0;
// The centre of a region is the one of so many uniform pixels that is farthest from the others' centres.
constexpr int kCentreCandidates = 10;
// A plane is given up when too few of so many pixels of its region are seen by both, or after so many pixels anywhere.
constexpr int kOverlapSamples = 100;
constexpr int kMostPixels = 20000;
// So many planes are tried in a region, then another scene. From kFreeTries on turns and tilts shrink with every scene.
constexpr int kPlaneTries = 20;
constexpr int kFreeTries = 10;
constexpr int kSceneTries = 300;
constexpr double kShrink = 0.97;

struct SeenPlane {
  VirtualPlane plane;
  Matrix3Parameters homography;
  std::vector<Eigen::Vector4d> matches;
};

struct PlaneScene {
  VirtualPair pair;
  Range depths = {1.0, 1.0};
  std::vector<Eigen::Vector2d> centres;  // A region is what is nearest to its centre.
  std::vector<SeenPlane> planes;

  double middle() const { return std::sqrt(depths.low * depths.high); }
};

std::size_t NearestCentre(const std::vector<Eigen::Vector2d>& centres, const Eigen::Vector2d& pixel) {
  std::size_t nearest = 0;
  for (std::size_t k = 1; k < centres.size(); ++k)
    if ((centres[k] - pixel).squaredNorm() < (centres[nearest] - pixel).squaredNorm()) nearest = k;
  return nearest;
}

// Spread over the image (Mitchell, "Spectrally optimal sampling for distribution ray tracing", 1991).
std::vector<Eigen::Vector2d> DrawCentres(const VirtualCamera& camera, int count, Rng rng) {
  std::vector<Eigen::Vector2d> centres = {camera.RandomPixel(rng)};
  while (static_cast<int>(centres.size()) < count) {
    Eigen::Vector2d farthest = Eigen::Vector2d::Zero();
    double distance = -1.0;
    for (int i = 0; i < kCentreCandidates; ++i) {
      const Eigen::Vector2d pixel = camera.RandomPixel(rng);
      const double from_others = (centres[NearestCentre(centres, pixel)] - pixel).norm();
      if (from_others > distance) farthest = pixel, distance = from_others;
    }
    centres.push_back(farthest);
  }
  return centres;
}

double ShareWithin(const std::vector<Eigen::Vector4d>& matches, const Matrix3Parameters& homography, double distance) {
  const auto near = std::count_if(matches.begin(), matches.end(), [&](const Eigen::Vector4d& match) {
    return SymmetricTransferError(homography, match.data()) <= distance;
  });
  return static_cast<double>(near) / static_cast<double>(matches.size());
}

class SyntheticPlaneViews : public GeneratedDataset {
 public:
  SyntheticPlaneViews(const SyntheticPlaneViewsOptions& options, std::uint64_t seed)
      : GeneratedDataset(options, "synthetic_plane_views/" + options.split, "plane_views/" + options.split + "/", seed),
        options_(options) {}

  Task task() const override { return Task::kHomography; }

  // Throws Error when no scene of so many planes is found.
  PlaneScene DrawScene(const std::vector<int>& sizes, const Rng& rng) const {
    for (int i = 0; i < kSceneTries; ++i) {
      const double scale = std::pow(kShrink, std::max(0, i - kFreeTries));
      PlaneScene scene = DrawViews(static_cast<int>(sizes.size()), scale, rng.Fork("scene", i));
      Rng planes = rng.Fork("planes", i);
      while (scene.planes.size() < sizes.size() && AddPlane(sizes[scene.planes.size()], scale, planes, &scene)) {
      }
      if (scene.planes.size() == sizes.size()) return scene;
    }
    throw Error("synthetic_plane_views: after " + std::to_string(kSceneTries) + " tries no scene of " +
                std::to_string(sizes.size()) + " planes that differ by more than inlier_threshold_px and are seen by " +
                "both cameras (baseline, rotation_deg, depth_ratio, min_overlap)");
  }

 private:
  Example Draw(std::uint64_t /*index*/, const Rng& rng) const override {
    const PointCounts counts = options_.matches.DrawCounts(task(), rng.Fork("counts"));
    const int planes = DrawStructureCount(options_.structures, rng.Fork("structures"));
    const int fewest = FewestOfStructure(task());
    const int inliers = std::clamp(counts.inliers, planes * fewest, counts.total);
    const PlaneScene scene =
        DrawScene(DrawStructureSizes(options_.structures, planes, inliers, fewest, rng.Fork("sizes")), rng);
    const ExactMatches exact = MatchesOf(scene, counts.total - inliers, rng);
    Example example = MakeMatches(options_.matches, task(), scene.pair, exact, counts.total, rng.Fork("matches"));
    for (const SeenPlane& seen : scene.planes) example.truth.structures.push_back(seen.homography);
    ArrangeStructures(1, &example.truth);
    example.truth.homography = scene.planes.front().plane.Homography(scene.pair);
    example.truth.pose = PoseOf(scene.pair.motion);
    return example;
  }

  PlaneScene DrawViews(int planes, double scale, const Rng& rng) const {
    PlaneScene scene;
    scene.pair.first = RandomCamera(options_.cameras, rng.Fork("camera"));
    scene.pair.second = RandomSecondCamera(options_.cameras, scene.pair.first, rng.Fork("second_camera"));
    Rng depth = rng.Fork("depth"), motion = rng.Fork("motion");
    scene.depths = {1.0, LogUniform(options_.depth_ratio, depth)};
    scene.centres = DrawCentres(scene.pair.first, planes, rng.Fork("centres"));
    const Eigen::Vector3d centre2 = LogUniform(options_.baseline, motion) * scene.middle() * RandomDirection(motion);
    const bool converging = motion.Uniform() < options_.converging;
    const double degrees = scale * motion.Uniform(options_.rotation_deg.low, options_.rotation_deg.high);
    const Eigen::Matrix3d turn = RandomRotation(degrees, motion);
    scene.pair.motion = MotionTo(centre2, turn, converging ? std::optional(scene.middle()) : std::nullopt);
    return scene;
  }

  // The plane of the next region with so many matches; false when none is found.
  bool AddPlane(int count, double scale, Rng& rng, PlaneScene* scene) const {
    for (int i = 0; i < kPlaneTries; ++i) {
      SeenPlane seen;
      seen.plane = DrawPlane(*scene, scale, rng);
      if (!(seen.plane.distance > 0.0 && seen.plane.FacesBoth(scene->pair.motion))) continue;
      seen.homography = AsParameters(seen.plane.Homography(scene->pair));
      if (!DrawMatches(*scene, count, rng, &seen) || !IsToldApart(seen, scene->planes)) continue;
      scene->planes.push_back(std::move(seen));
      return true;
    }
    return false;
  }

  // Through a point that the region's centre shows.
  VirtualPlane DrawPlane(const PlaneScene& scene, double scale, Rng& rng) const {
    const Eigen::Vector3d ray = scene.pair.first.Ray(scene.centres[scene.planes.size()]);
    const Eigen::Vector3d point = ray * LogUniform(scene.depths, rng);
    const double tilt = scale * rng.Uniform(options_.plane_tilt_deg.low, options_.plane_tilt_deg.high);
    const Eigen::Vector3d normal = Tilted(Eigen::Vector3d::UnitZ(), tilt, rng);
    return {normal, normal.dot(point)};
  }

  // Uniform in the part of the region that both images show; false where that is too small.
  bool DrawMatches(const PlaneScene& scene, int count, Rng& rng, SeenPlane* seen) const {
    const std::size_t region = scene.planes.size();
    int inside = 0;
    Eigen::Vector4d match;
    for (int i = 0; i < kMostPixels; ++i) {
      const Eigen::Vector2d pixel = scene.pair.first.RandomPixel(rng);
      if (NearestCentre(scene.centres, pixel) != region) continue;
      ++inside;
      if (seen->plane.Match(scene.pair, scene.depths, pixel, &match)) seen->matches.push_back(match);
      const auto found = static_cast<int>(seen->matches.size());
      if (inside == kOverlapSamples && found < options_.min_overlap * inside) return false;
      if (inside < kOverlapSamples || found < count) continue;
      seen->matches.resize(count);
      return true;
    }
    return false;
  }

  bool IsToldApart(const SeenPlane& plane, const std::vector<SeenPlane>& others) const {
    const double distance = kSharedThresholds * options_.matches.inlier_threshold_px;
    return std::none_of(others.begin(), others.end(), [&](const SeenPlane& other) {
      return ShareWithin(plane.matches, other.homography, distance) > kSharedMost ||
             ShareWithin(other.matches, plane.homography, distance) > kSharedMost;
    });
  }

  ExactMatches MatchesOf(const PlaneScene& scene, int outliers, const Rng& rng) const {
    ExactMatches exact;
    for (std::size_t k = 0; k < scene.planes.size(); ++k) {
      const auto& matches = scene.planes[k].matches;
      exact.planes.push_back(scene.planes[k].plane.Homography(scene.pair));
      exact.inliers.insert(exact.inliers.end(), matches.begin(), matches.end());
      exact.assignment.resize(exact.inliers.size(), static_cast<std::int32_t>(k + 1));
    }
    const int displaced = DrawDisplacedCount(options_.matches, outliers, rng.Fork("displaced_count"));
    Rng pixels = rng.Fork("displaced");
    Eigen::Vector4d match;
    while (static_cast<int>(exact.displaced.size()) < displaced) {
      const Eigen::Vector2d pixel = scene.pair.first.RandomPixel(pixels);
      const SeenPlane& seen = scene.planes[NearestCentre(scene.centres, pixel)];
      if (seen.plane.Match(scene.pair, scene.depths, pixel, &match)) exact.displaced.push_back(match);
    }
    return exact;
  }

  SyntheticPlaneViewsOptions options_;
};

}  // namespace

SyntheticPlaneViewsOptions::SyntheticPlaneViewsOptions() {
  matches.num_points = {100, 300};
  matches.outlier_ratio = {0.1, 0.6};
  matches.inlier_threshold_px = 2.0;
}

void SyntheticPlaneViewsOptions::Bind(OptionsBinder& b) {
  structures.Bind(b);
  matches.Bind(b);
  cameras.Bind(b);
  b.Field("depth_ratio", depth_ratio, Within(1.0, 1000.0)).Help("farthest over nearest depth, log-uniform");
  b.Field("plane_tilt_deg", plane_tilt_deg, Within(0.0, 85.0))
      .Help("between a plane's normal and the first camera's axis");
  b.Field("baseline", baseline, Within(1e-4, 10.0))
      .Help("over the geometric mean of nearest and farthest depth, log-uniform");
  b.Field("rotation_deg", rotation_deg, Within(0.0, 180.0)).Help("turn of the second camera about a random axis");
  b.Field("converging", converging, Within(0.0, 1.0))
      .Help("probability that it is first turned towards the middle of the scene");
  b.Field("min_overlap", min_overlap, Within(0.05, 0.8))
      .Help("least share of a plane's region in image 1 that image 2 shows too");
  BindStream(b);
}

std::unique_ptr<Dataset> MakeSyntheticPlaneViews(const SyntheticPlaneViewsOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  CheckCounts(options.matches.num_points, Task::kHomography);
  CheckStructures(options.structures, Task::kHomography, options.matches.num_points.low);
  auto dataset = std::make_unique<SyntheticPlaneViews>(options, seed);
  // Ranges that no scene can meet are better found now than in the middle of a training.
  const int most = static_cast<int>(options.structures.structures.high);
  dataset->DrawScene(std::vector<int>(most, FewestOfStructure(Task::kHomography)), Rng(seed).Fork("trial"));
  return dataset;
}

namespace {

const RegisteredDataset<SyntheticPlaneViewsOptions> kSyntheticPlaneViews(
    "synthetic_plane_views", DataSource::kGenerated, "Random scenes of several planes seen by two random cameras.",
    MakeSyntheticPlaneViews);

}  // namespace

}  // namespace diffsac
