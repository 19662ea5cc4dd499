#include "lab/images/match_pair.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/images/exif_focal.h"
#include "lab/images/exif_test_util.h"
#include "lab/images/image_test_util.h"
#include "lab/images/pictures.h"

namespace diffsac {
namespace {

using Catch::Contains;

struct TwoViews {
  TemporaryFolder folder;
  LensCamera camera;
  std::string first = folder.File("a-1.png"), second = folder.File("b.jpg");

  TwoViews() {
    camera.K << 300.0, 0.0, 159.5, 0.0, 300.0, 119.5, 0.0, 0.0, 1.0;
    const cv::Mat texture = Texture(900, 700, 3);
    cv::imwrite(first, Render(texture, camera, NearbyPose(0), {320, 240}));
    cv::imwrite(second, Render(texture, camera, NearbyPose(1), {320, 240}));
  }
};

TEST_CASE("two images are matched as pairs are, whatever folders they are in") {
  const TwoViews views;
  const ImagePair matched = MatchTwoImages(views.first, views.second, {}, {"", 300.0, {159.5, 119.5}});
  const Example& pair = matched.example;
  CHECK(pair.id == "a_1-b");
  CHECK(pair.problem.size2.width == 320);
  CHECK(pair.problem.snn_ratio.size() == pair.problem.points.rows());
  CHECK(pair.problem.scale_rotation_changes.rows() == pair.problem.points.rows());
  REQUIRE(pair.problem.cameras);
  CHECK(pair.problem.cameras->K2(0, 0) == 300.0);
  CHECK(matched.ms_keypoints > 0.0);
  const RigidMotion motion = RelativeMotion(NearbyPose(0), NearbyPose(1));
  GroundTruth truth;
  truth.motion = motion;
  CompleteTruth(pair.problem, &truth);
  const Eigen::VectorXd distances = TruthDistances(pair.problem, truth);
  CHECK((distances.array() <= 1.0).count() > 0.6 * static_cast<double>(distances.size()));
  CHECK_FALSE(MatchTwoImages(views.first, views.second, {}, {}).example.problem.cameras);
}

TEST_CASE("equal names in two folders are told apart") {
  const TwoViews views;
  const auto in = [&](const std::string& name) {
    const std::string path = views.folder.File(name);
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    std::filesystem::copy_file(views.first, path);
    return path;
  };
  const std::string a = in("a/in/1.png"), b = in("b/in/1.png"), other = in("a/in/1.jpg");
  CHECK(MatchTwoImages(a, b, {}, {}).example.id == "a_in_1-b_in_1");
  CHECK(MatchTwoImages(a, other, {}, {}).example.id == "1_1-1_2");
}

TEST_CASE("without a calibration the focal lengths of EXIF data are hints") {
  const TwoViews views;
  ExifBytes exif;
  exif.shorts[0xA405] = 26;
  WriteFileAtomically(views.second, WithExif(ReadFile(views.second), exif.ToString()));
  const Problem problem = MatchTwoImages(views.first, views.second, {}, {}).example.problem;
  CHECK_FALSE(problem.camera_prior1.focal);
  REQUIRE(problem.camera_prior2.focal);
  CHECK(problem.camera_prior2.focal->focal == Approx(26.0 / std::hypot(36.0, 24.0) * 400.0));
  CHECK(problem.camera_prior2.focal->log_sigma == kExifLogSigma);
  const Problem calibrated = MatchTwoImages(views.first, views.second, {}, {"", 300.0, {159.5, 119.5}}).example.problem;
  CHECK_FALSE(calibrated.camera_prior2.focal);
}

TEST_CASE("a picture shows the inliers of two images") {
  const TwoViews views;
  const Example pair = MatchTwoImages(views.first, views.second, {}, {}).example;
  const std::string path = views.folder.File("picture.png");
  std::vector<std::uint8_t> inliers(static_cast<std::size_t>(pair.problem.points.rows()), 1);
  DrawInliers(views.first, views.second, pair.problem.points, inliers, "caption", path);
  const cv::Mat picture = cv::imread(path);
  CHECK(picture.cols == 2 * 320 + 8);
  const std::string jpeg = views.folder.File("picture.jpg");
  DrawInliers(views.first, views.second, pair.problem.points, inliers, "caption", jpeg);
  CHECK(ReadFile(jpeg).starts_with("\xFF\xD8"));
  CHECK_THROWS_WITH(
      DrawInliers(views.first, views.second, pair.problem.points, inliers, "", views.folder.File("p.txt")),
      Contains("p.txt: expected a name that ends in .png"));
  CHECK_THROWS_WITH(
      DrawInliers(views.first, views.second, pair.problem.points, inliers, "", views.folder.File("no/p.png")),
      Contains("no/p.png"));
}

TEST_CASE("files that are no images, cut ones and blank ones are named") {
  const TwoViews views;
  const auto match = [&](const std::string& second) { return MatchTwoImages(views.first, second, {}, {}); };
  CHECK_THROWS_WITH(match(views.folder.File("none.jpg")), Contains("none.jpg: no such file"));
  const std::string whole = ReadFile(views.second);
  for (const double share : {0.3, 0.7, 0.98}) {
    WriteFileAtomically(views.folder.File("cut.jpg"), whole.substr(0, static_cast<std::size_t>(share * whole.size())));
    CHECK_THROWS_WITH(match(views.folder.File("cut.jpg")), Contains("cut.jpg: not an image, or truncated"));
  }
  WriteFileAtomically(views.folder.File("text.jpg"), "no image");
  CHECK_THROWS_WITH(match(views.folder.File("text.jpg")), Contains("text.jpg: not an image"));
  WriteFileAtomically(views.folder.File("empty.jpg"), "");
  CHECK_THROWS_WITH(match(views.folder.File("empty.jpg")), Contains("empty.jpg: not an image"));
  cv::imwrite(views.folder.File("blank.png"), cv::Mat(200, 200, CV_8U, cv::Scalar(7)));
  CHECK_THROWS_WITH(match(views.folder.File("blank.png")), Contains("blank.png: no keypoints"));
  CHECK_THROWS_WITH(MatchTwoImages(views.first, views.second, {}, {views.folder.File("K.txt"), 0.0, {}}),
                    Contains("K.txt"));
  WriteFileAtomically(views.folder.File("trailing.jpg"), whole + "appended");
  CHECK(match(views.folder.File("trailing.jpg")).example.problem.points.rows() > 0);
}

}  // namespace
}  // namespace diffsac
