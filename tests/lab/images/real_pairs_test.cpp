// The conventions of the real sets beside the checkout: matches of real images must obey the ground truth as it is
// read, and must not obey it under the opposite convention.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include <Eigen/LU>

#include "core/errors.h"
#include "lab/files/correspondence_files.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/images/image_features.h"
#include "lab/images/image_source.h"

namespace diffsac {
namespace {

// The folder of a set, or "" after saying that the test is skipped.
std::string SharedFolder(const std::string& name) {
  const std::string folder = std::string(DIFFSAC_SHARED_DATA) + "/" + name;
  if (std::filesystem::is_directory(folder)) return folder;
  WARN("skipped: no folder " << folder);
  return "";
}

// Runs data_tools/convert.py on a set; false after saying that the test is skipped.
bool Convert(const TemporaryFolder& folder, const std::string& format, const std::string& name,
             const std::string& options = "") {
  const std::string input = SharedFolder(name);
  if (input.empty()) return false;
  const std::string words = " -B '" DIFFSAC_SOURCE_DIR "/data_tools/convert.py' " + format + " '" + input + "' '" +
                            folder / name + "' " + options;
  for (const std::string python : {"python3", "/usr/bin/python3"})
    if (std::system((python + words + " >/dev/null 2>&1").c_str()) == 0) return true;
  WARN("skipped: data_tools/convert.py does not run here");
  return false;
}

std::optional<ImageSource> Converted(const TemporaryFolder& folder, const std::string& format, const std::string& name,
                                     const std::string& options = "") {
  if (!Convert(folder, format, name, options)) return {};
  return ReadColmap(folder / name);
}

// Matches with a ratio of at most 0.8, so that the share near the truth says something about the truth.
Example MatchPair(const ImageSource& source, int scene, std::size_t index, int max_image_size) {
  FeatureOptions options;
  options.max_image_size = max_image_size;
  options.max_keypoints = 4000;
  const SourcePair& pair = source.scenes.at(scene).pairs.at(index);
  const SourceImage &image1 = source.images[pair.image1], &image2 = source.images[pair.image2];
  const ImageFeatures first = ExtractFeatures(image1.path, options), second = ExtractFeatures(image2.path, options);
  Example example;
  Problem& problem = example.problem;
  problem.points.resize(first.positions.rows(), 4);
  Eigen::Index count = 0;
  const auto pinhole = [](const SourceImage& image, const Eigen::Vector2d& pixel) -> Eigen::RowVector2d {
    return (image.camera ? image.camera->Undistort(pixel) : pixel).transpose();
  };
  for (const DescriptorMatch& match : MatchMutually(first.descriptors, second.descriptors))
    if (match.ratio <= 0.8)
      problem.points.row(count++) << pinhole(image1, first.positions.row(match.first)),
          pinhole(image2, second.positions.row(match.second));
  problem.points.conservativeResize(count, 4);
  if (image1.camera) {
    problem.cameras = CameraPair{image1.camera->K, image2.camera->K};
    if (image1.camera->size.width > 0) CHECK(image1.camera->size == first.size);
  }
  example.truth.homography = pair.homography;
  if (image1.pose) example.truth.motion = RelativeMotion(*image1.pose, *image2.pose);
  CompleteTruth(problem, &example.truth);
  return example;
}

std::size_t SharpestTurn(const ImageSource& source, int scene) {
  std::size_t best = 0;
  double least_trace = 3.0;
  const auto& pairs = source.scenes[scene].pairs;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double trace =
        RelativeMotion(*source.images[pairs[i].image1].pose, *source.images[pairs[i].image2].pose).rotation.trace();
    if (trace < least_trace) least_trace = trace, best = i;
  }
  return best;
}

double ShareNear(const Problem& problem, const GroundTruth& truth, double threshold_px) {
  return (TruthDistances(problem, truth).array() < threshold_px).cast<double>().mean();
}

void CheckPose(const Example& pair, double threshold_px, double share) {
  REQUIRE(pair.problem.points.rows() > 50);
  CHECK(ShareNear(pair.problem, pair.truth, threshold_px) > share);
  GroundTruth opposite;
  opposite.motion = Inverse(*pair.truth.motion);
  CompleteTruth(pair.problem, &opposite);
  CHECK(ShareNear(pair.problem, opposite, threshold_px) < 0.5 * share);
}

}  // namespace

TEST_CASE("real data: KITTI's poses explain its matches") {
  const std::string folder = SharedFolder("kitti");
  if (folder.empty()) return;
  for (const char* sequence : {"00", "01"}) {
    const ImageSource source = ReadKitti(folder, sequence, {1, {1, 2, 5, 10}});
    REQUIRE(source.scenes.size() == 4);
    CHECK(source.scenes[0].pairs.size() + 1 == source.images.size());
    CHECK(source.scenes[3].pairs.size() + 10 == source.images.size());
    CHECK(source.images[0].camera->K(0, 0) == Approx(718.856));
    CHECK(source.images[0].camera->K(1, 2) == Approx(185.2157));
    // Driving straight on, E and its transpose are nearly the same: only a bend tells the directions apart.
    CheckPose(MatchPair(source, 2, SharpestTurn(source, 2), 0), 2.0, 0.5);
  }
}

TEST_CASE("real data: COLMAP's model of the Lund door explains its matches") {
  const std::string folder = SharedFolder("lund_door");
  if (folder.empty()) return;
  const ImageSource source = ReadColmap(folder);
  CHECK(source.images.size() == 12);
  CHECK(source.scenes[0].pairs.size() == 66);
  CHECK(source.images[0].camera->colmap->parameters.back() == Approx(-0.0336422));
  CheckPose(MatchPair(source, 0, 3, 800), 2.0, 0.8);
}

TEST_CASE("real data: converted poses of castle-P19, the fox, mobilebrick and 7-Scenes explain their matches") {
  const TemporaryFolder folder;
  // The first pair is (0, 1); images are reduced to a third, and so is the precision.
  if (const auto castle = Converted(folder, "strecha", "strecha/castle-P19")) {
    CHECK(castle->images.size() == 19);
    CHECK(castle->scenes[0].pairs.size() == 171);
    CheckPose(MatchPair(*castle, 0, 0, 1024), 3.0, 0.7);
  }
  if (const auto fox = Converted(folder, "nerf", "fox")) {
    CHECK(fox->images.size() == 50);
    CHECK(fox->images[0].camera->K(0, 2) == Approx(554.058));
    CheckPose(MatchPair(*fox, 0, 0, 960), 2.0, 0.8);
  }
  if (const auto brick = Converted(folder, "poses", "mobilebrick")) {
    CHECK(brick->images.size() == 5);
    CheckPose(MatchPair(*brick, 0, 0, 960), 3.0, 0.6);
  }
  // Depth maps lie beside the images.
  if (const auto kitchen = Converted(folder, "poses", "sevenscenes_redkitchen", "--focal 525 --center 320,240")) {
    CHECK(kitchen->images.size() == 100);
    CheckPose(MatchPair(*kitchen, 0, 1, 0), 3.0, 0.6);
  }
}

TEST_CASE("real data: homographies explain the matches of graf and dogman") {
  for (const char* name : {"oxford_graf", "hpatches_v_dogman/v_dogman"}) {
    const std::string folder = SharedFolder(name);
    if (folder.empty()) return;
    const ImageSource source = ReadHomographies(folder);
    CHECK(source.scenes[0].pairs.size() == 5);
    const Example pair = MatchPair(source, 0, 0, 0);
    CHECK(ShareNear(pair.problem, pair.truth, 3.0) > 0.7);
    GroundTruth opposite;
    opposite.homography = pair.truth.homography->inverse();
    CHECK(ShareNear(pair.problem, opposite, 3.0) < 0.05);
  }
}

TEST_CASE("real data: the fundamental matrices of AdelaideRMF explain its labelled inliers") {
  const TemporaryFolder folder;
  if (!Convert(folder, "adelaidermf", "adelaidermf")) return;
  const CorrespondenceScene labelled(folder / "adelaidermf/adelaidermf"),
      tentative(folder / "adelaidermf/adelaidermf_sift");
  REQUIRE(labelled.size() == 18);
  REQUIRE(tentative.pairs() == labelled.pairs());
  for (std::int64_t i = 0; i < 18; ++i) {
    const Example pair = labelled.Read(i), other = tentative.Read(i);
    CAPTURE(pair.id);
    const Eigen::VectorXd distances = TruthDistances(pair.problem, pair.truth);
    double near[2] = {0, 0}, count[2] = {0, 0};
    for (Eigen::Index k = 0; k < distances.size(); ++k) {
      const int inlier = pair.truth.assignment[k] > 0 ? 1 : 0;
      near[inlier] += distances[k] < 3.0 ? 1 : 0;
      count[inlier] += 1;
    }
    CHECK(near[1] / count[1] > 0.89);
    // Matches that are on no labelled plane may well obey F.
    CHECK(near[1] / count[1] > near[0] / count[0] + 0.3);
    // The tentative matches are of the same images; a good ratio goes with the truth.
    CHECK(ShareNear(other.problem, other.truth, 3.0) > 0.3);
    CHECK((other.problem.snn_ratio.minCoeff() >= 0.0 && other.problem.snn_ratio.maxCoeff() <= 1.0));
  }
}

}  // namespace diffsac
