// `diffsac_prepare pairs --format colmap_points`: each image of a COLMAP text model against the scene's points as the
// other images see them. A point's descriptor is the mean of those of the keypoints within 2 pixels of its observations
// in the others; matches are mutual nearest neighbours. OUTPUT/SCENE/scene_points.h5 is what the dataset absolute_poses
// reads.
#include <H5Cpp.h>

#include <filesystem>
#include <map>
#include <numeric>
#include <vector>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/colmap/model.h"
#include "lab/config/progress.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/files/hdf5_output.h"
#include "lab/images/feature_store.h"
#include "lab/images/run_pairs.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr double kNearPx = 2.0;  // between an observation and its keypoint

using PointId = std::int64_t;
using ScenePoints = std::map<PointId, Eigen::Vector3d>;

struct Observation {
  PointId point;
  Eigen::Vector2d pixel;  // as the file's pixels are counted: the first centre is (0, 0)
};

// POINT3D_ID X Y Z R G B ERROR TRACK...
ScenePoints ReadScenePoints(const std::string& path) {
  ScenePoints points;
  ColmapLines lines(path);
  while (lines.Next()) {
    const auto words = lines.Words();
    if (words.empty()) continue;
    if (words.size() < 8) lines.Fail("expected POINT3D_ID X Y Z R G B ERROR TRACK");
    points[lines.Whole(words[0])] << lines.Number(words[1]), lines.Number(words[2]), lines.Number(words[3]);
  }
  if (points.empty()) throw Error(path + ": there is no point");
  return points;
}

// By the image's name: X Y POINT3D_ID of each keypoint, -1 for those that are no point's.
std::map<std::string, std::vector<Observation>> ReadObservations(const std::string& path) {
  std::map<std::string, std::vector<Observation>> all;
  ColmapLines lines(path);
  while (lines.Next()) {
    if (lines.Words().empty()) continue;
    std::vector<Observation>& seen = all[ImageName(lines.After(9))];
    if (!lines.Next()) break;
    const auto words = lines.Words();
    if (words.size() % 3 != 0) lines.Fail("expected X Y POINT3D_ID for each keypoint");
    for (std::size_t i = 0; i < words.size(); i += 3) {
      const PointId point = lines.Whole(words[i + 2]);
      // From COLMAP's pixels, whose first centre is (0.5, 0.5).
      const Eigen::Vector2d pixel(lines.Number(words[i]) - 0.5, lines.Number(words[i + 1]) - 0.5);
      if (point >= 0) seen.push_back({point, pixel});
    }
  }
  return all;
}

// -1 when none is near.
int NearestKeypoint(const PointMatrix& keypoints, const Eigen::Vector2d& pixel) {
  int nearest = -1;
  double least = kNearPx * kNearPx;
  for (Eigen::Index i = 0; i < keypoints.rows(); ++i) {
    const double dx = keypoints(i, 0) - pixel[0], dy = keypoints(i, 1) - pixel[1];
    if (dx * dx + dy * dy > least) continue;
    least = dx * dx + dy * dy;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

/// Points with their descriptors, N × 3 and N × d of unit length.
struct DescribedPoints {
  PointMatrix points;
  DescriptorMatrix descriptors;
};

/// What the images say about each point, gathered once; each image is then matched with what the others say.
class SceneDescriptors {
 public:
  void Add(int image, const ImageFeatures& features, const std::vector<Observation>& observations) {
    for (const Observation& seen : observations) {
      const int keypoint = NearestKeypoint(features.positions, seen.pixel);
      if (keypoint >= 0) views_[seen.point].emplace_back(image, features.descriptors.row(keypoint).transpose());
    }
  }

  DescribedPoints Without(int image, const ScenePoints& points) const {
    std::vector<Eigen::VectorXf> means;
    std::vector<Eigen::Vector3d> places;
    for (const auto& [point, views] : views_) {
      const auto place = points.find(point);
      Eigen::VectorXf sum = Eigen::VectorXf::Zero(views[0].second.size());
      for (const auto& [other, descriptor] : views)
        if (other != image) sum += descriptor;
      if (place == points.end() || !(sum.norm() > 0.0f)) continue;
      means.push_back(sum.normalized());
      places.push_back(place->second);
    }
    DescribedPoints described{PointMatrix(static_cast<Eigen::Index>(places.size()), 3), {}};
    described.descriptors.resize(described.points.rows(), means.empty() ? 0 : means[0].size());
    for (Eigen::Index i = 0; i < described.points.rows(); ++i) {
      described.points.row(i) = places[i].transpose();
      described.descriptors.row(i) = means[i].transpose();
    }
    return described;
  }

 private:
  std::map<PointId, std::vector<std::pair<int, Eigen::VectorXf>>> views_;
};

/// One group of the file (lab/data/absolute_pose_dataset.cpp).
struct MatchedImage {
  std::string name;
  PointMatrix points;  // N × 5
  std::vector<double> ratios;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> K;
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> pose;
};

MatchedImage MatchWithScene(const SourceImage& image, const ImageFeatures& features, const DescribedPoints& scene) {
  MatchedImage matched;
  matched.name = image.name;
  matched.K = image.camera->K;
  matched.pose << image.pose->rotation, image.pose->translation;
  const auto matches = MatchMutually(features.descriptors, scene.descriptors);
  matched.points.resize(static_cast<Eigen::Index>(matches.size()), 5);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const Eigen::Vector2d pixel = features.positions.row(matches[i].first).transpose();
    matched.points.row(static_cast<Eigen::Index>(i)) << scene.points.row(matches[i].second),
        image.camera->Undistort(pixel).transpose();
    matched.ratios.push_back(matches[i].ratio);
  }
  return matched;
}

void Write(const std::string& path, const std::vector<MatchedImage>& images) {
  WriteFileAtomically(path, [&](const std::string& temporary) {
    Hdf5Output output(temporary, path);
    output.Use([&](H5::H5File& file) {
      for (const MatchedImage& image : images) {
        const H5::Group group = file.createGroup(image.name);
        const auto count = static_cast<hsize_t>(image.points.rows());
        WriteNumbers(group, "points", image.points.data(), {count, 5});
        WriteNumbers(group, "ratios", image.ratios.data(), {count});
        WriteNumbers(group, "K", image.K.data(), {3, 3});
        WriteNumbers(group, "pose", image.pose.data(), {3, 4});
      }
    });
    output.Close();
  });
}

/// Images that can be read, in the source's order; the others are named in `result`. None when stopped.
std::vector<int> PrepareFeatures(const ImageSource& source, int threads, FeatureStore* store,
                                 const std::atomic<bool>& stop, PrepareResult* result) {
  std::vector<int> images(source.images.size()), good;
  std::iota(images.begin(), images.end(), 0);
  std::vector<std::string> problems;
  result->finished = store->PrepareAll(images, threads, stop, &problems);
  for (const int i : images) {
    if (problems[i].empty()) {
      good.push_back(i);
    } else {
      LogWarning("left out: " + problems[i]);
      result->left_out.push_back(problems[i]);
    }
  }
  return good;
}

std::vector<MatchedImage> MatchImages(const ImageSource& source, const FeatureStore& store,
                                      const std::vector<int>& images, int threads, const std::string& model,
                                      const std::atomic<bool>& stop) {
  const ScenePoints points = ReadScenePoints((fs::path(model) / "points3D.txt").string());
  const auto observations = ReadObservations((fs::path(model) / "images.txt").string());
  SceneDescriptors seen;
  for (const int i : images) seen.Add(i, store.Load(i), observations.at(source.images[i].name));
  std::vector<MatchedImage> matched(images.size());
  Progress progress("images", static_cast<std::int64_t>(images.size()));
  ParallelFor(static_cast<std::int64_t>(images.size()), threads, [&](std::int64_t k) {
    if (stop) return;
    const DescribedPoints others = seen.Without(images[k], points);
    if (others.points.rows() < 2) throw Error(model + ": no point of another image has a keypoint near it");
    matched[k] = MatchWithScene(source.images[images[k]], store.Load(images[k]), others);
    progress.Advance();
  });
  return matched;
}

PrepareResult WriteScenePoints(const PairsRequest& request, const std::atomic<bool>& stop) {
  request.options.Check();
  PrepareResult result;
  const ImageSource source = ReadColmap(request.input);
  for (const LeftOutImage& image : source.left_out) {
    LogWarning("left out: " + image.problem);
    result.left_out.push_back(image.problem);
  }
  const std::string scene = request.scene.empty() ? source.scenes[0].name : request.scene;
  const std::string folder = (fs::path(request.output) / scene).string();
  const std::string path = (fs::path(folder) / "scene_points.h5").string();
  if (!request.options.overwrite && fs::exists(path)) {
    LogInfo(path + ": already there");
    result.already_there = 1;
    return result;
  }
  MakeWritableFolder(folder);
  FeatureStore store(source, request.options.features, request.options.import_descriptors,
                     (fs::path(request.output) / (".keypoints-" + scene)).string());
  if (store.distance() != DescriptorDistance::kEuclidean)
    throw Error("--format colmap_points needs descriptors that have a mean: sift or rootsift");
  const std::vector<int> images = PrepareFeatures(source, request.options.threads, &store, stop, &result);
  if (result.finished && images.size() < 2)
    throw Error(request.input + ": fewer than two images can be read" +
                (result.left_out.empty() ? "" : " (" + result.left_out[0] + ")"));
  std::vector<MatchedImage> matched;
  if (result.finished)
    matched = MatchImages(source, store, images, request.options.threads, ColmapModelFolder(request.input), stop);
  result.finished = !stop;
  if (!result.finished) return result;
  Write(path, matched);
  store.RemoveCache();
  LogInfo(path + ": " + std::to_string(matched.size()) + " images");
  result.written = 1;
  return result;
}

const Registered<ImageFormat> kColmapPoints("colmap_points", {.write = WriteScenePoints});

}  // namespace
}  // namespace diffsac
