#include "lab/images/run_pairs.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <sstream>

#include "core/errors.h"
#include "diffsac/problem/deduplicated_points.h"
#include "lab/files/correspondence_files.h"
#include "lab/files/files.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/images/feature_store.h"
#include "lab/images/image_test_util.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

const std::atomic<bool> kNeverStop{false};
constexpr ImageSize kSize{320, 240};

std::string Text(const Eigen::MatrixXd& matrix) {
  static const Eigen::IOFormat format(Eigen::FullPrecision, Eigen::DontAlignCols, " ", "\n");
  std::ostringstream text;
  text << matrix.format(format) << "\n";
  return text.str();
}

LensCamera PlainCamera() {
  LensCamera camera;
  camera.K = Calibration(300, 310, 158, 121);
  return camera;
}

// The same three views of one texture, in each of the layouts, all written here from the formats' own documents.
struct Views {
  cv::Mat texture = Texture(900, 700, 5);
  std::vector<RigidMotion> poses = {NearbyPose(0), NearbyPose(1), NearbyPose(2)};

  void Write(const std::string& path, int i, const LensCamera& camera) const {
    WriteImage(path, Render(texture, camera, poses[i], kSize));
  }
};

void WriteKitti(const Views& views, const std::string& root) {
  fs::create_directories(root + "/sequences/07/image_0");
  fs::create_directories(root + "/poses");
  std::string poses;
  for (int i = 0; i < 3; ++i) {
    views.Write(root + "/sequences/07/image_0/00000" + std::to_string(i) + ".png", i, PlainCamera());
    Eigen::Matrix4d world_to_camera = Eigen::Matrix4d::Identity();
    world_to_camera.topLeftCorner<3, 3>() = views.poses[i].rotation;
    world_to_camera.topRightCorner<3, 1>() = views.poses[i].translation;
    const Eigen::Matrix4d to_world = world_to_camera.inverse();
    const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> rows = to_world.topRows<3>();
    poses += Text(Eigen::Map<const Eigen::Matrix<double, 1, 12>>(rows.data()));
  }
  WriteRaw(root + "/poses/07.txt", poses);
  WriteRaw(root + "/sequences/07/calib.txt", "P0: 300 0 158 0 0 310 121 0 0 0 1 0\n");
}

void WriteColmap(const Views& views, const std::string& root) {
  fs::create_directories(root + "/images");
  const LensCamera camera = CameraOfColmap({2, {320, 240}, {300, 158.5, 121.5, -0.15}}, root);
  const std::vector<std::string> names = {"im-0.png", "im-1.png", "im-2.png"};
  for (int i = 0; i < 3; ++i) views.Write(root + "/images/" + names[i], i, camera);
  WriteColmapModel(root, "SIMPLE_RADIAL 320 240 300 158.5 121.5 -0.15", names, views.poses);
}

// The same without distortion.
void WritePinhole(const Views& views, const std::string& root) {
  fs::create_directories(root + "/images");
  const std::vector<std::string> names = {"0000.png", "0001.png", "0002.png"};
  for (int i = 0; i < 3; ++i) views.Write(root + "/images/" + names[i], i, PlainCamera());
  WriteColmapModel(root, "PINHOLE 320 240 300 310 158.5 121.5", names, views.poses);
}

PairsRequest Request(const std::string& format, const std::string& input, const std::string& output) {
  PairsRequest request;
  request.format = format;
  request.input = input;
  request.output = output;
  if (format == "kitti") request.sequence = "07";
  request.options.threads = 2;
  return request;
}

double ShareNearTruth(const Example& pair, double threshold_px) {
  return (TruthDistances(pair.problem, pair.truth).array() < threshold_px).cast<double>().mean();
}

std::string AllBytes(const std::string& folder) {
  std::vector<std::string> paths;
  for (const auto& entry : fs::directory_iterator(folder)) paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  std::string bytes;
  for (const std::string& path : paths) bytes += fs::path(path).filename().string() + ReadFile(path);
  return bytes;
}

}  // namespace

TEST_CASE("views in every layout give matches on their true geometry") {
  TemporaryFolder folder;
  const Views views;
  WriteKitti(views, folder / "kitti");
  WriteColmap(views, folder / "colmap");
  for (const std::string format : {"kitti", "colmap"}) {
    CAPTURE(format);
    const std::string output = folder / ("out_" + format);
    REQUIRE(RunPairs(Request(format, folder / format, output), kNeverStop).finished);
    const std::string scene_path = output + "/" + (format == "kitti" ? "kitti_07_step_01" : format);
    const CorrespondenceScene scene(scene_path);
    REQUIRE(scene.size() == (format == "kitti" ? 2 : 3));
    for (int i = 0; i < scene.size(); ++i) {
      const Example pair = scene.Read(i);
      CAPTURE(pair.id);
      REQUIRE(pair.problem.points.rows() > 60);
      CHECK(ShareNearTruth(pair, 1.0) > 0.6);
      CHECK(pair.problem.size1 == kSize);
      CHECK(pair.problem.cameras);
      // The opposite direction of the same motion must not fit.
      Example wrong = pair;
      wrong.truth = {};
      wrong.truth.motion = Inverse(*pair.truth.motion);
      CompleteTruth(wrong.problem, &wrong.truth);
      CHECK(ShareNearTruth(wrong, 1.0) < 0.3);
    }
    const Example first = scene.Read(0);
    const RigidMotion expected = RelativeMotion(views.poses[0], views.poses[1]);
    CHECK(first.truth.motion->rotation.isApprox(expected.rotation, 1e-9));
    CHECK(first.truth.motion->translation.isApprox(expected.translation, 1e-9));
    CHECK(DeduplicatedPoints(first.problem).repeated() == 0);
    CHECK(first.problem.scale_rotation_changes.rows() == first.problem.points.rows());
  }
}

TEST_CASE("the files depend neither on threads nor on an earlier run") {
  TemporaryFolder folder;
  WritePinhole(Views(), folder / "s");
  PairsRequest request = Request("colmap", folder / "s", folder / "one");
  request.options.threads = 1;
  request.options.descriptors = true;
  REQUIRE(RunPairs(request, kNeverStop).finished);
  request.options.threads = 4;
  request.output = folder / "four";
  REQUIRE(RunPairs(request, kNeverStop).finished);
  CorrespondenceOptions options;
  options.descriptors = true;
  const CorrespondenceScene one(folder / "one/s", options), four(folder / "four/s", options);
  for (int i = 0; i < 3; ++i) {
    const Problem a = one.Read(i).problem, b = four.Read(i).problem;
    CHECK((a.points == b.points && a.snn_ratio == b.snn_ratio && a.descriptors == b.descriptors));
    REQUIRE(a.descriptors.cols() == 256);
    // Descriptors belong to their match: an equal pair has a small ratio, and its two halves are near.
    Eigen::Index best = 0, worst = 0;
    a.snn_ratio.minCoeff(&best);
    a.snn_ratio.maxCoeff(&worst);
    const auto distance = [&](Eigen::Index k) {
      return (a.descriptors.row(k).head(128) - a.descriptors.row(k).tail(128)).norm();
    };
    CHECK(distance(best) < distance(worst));
  }
  // The images' small copies; without them and without descriptors in the same folder: both are gone.
  const std::string copies = ReadFile(folder / "one/s/thumbnails.h5");
  CHECK(Has(copies, "\xff\xd8\xff"));
  CHECK(copies == ReadFile(folder / "four/s/thumbnails.h5"));
  request.options.thumbnails = false;
  request.options.descriptors = false;
  request.options.overwrite = true;
  REQUIRE(RunPairs(request, kNeverStop).finished);
  CHECK(!fs::exists(folder / "four/s/descriptors.h5"));
  CHECK(!fs::exists(folder / "four/s/thumbnails.h5"));
  const std::string before = AllBytes(folder / "four/s");
  REQUIRE(RunPairs(request, kNeverStop).finished);
  const CorrespondenceScene again(folder / "four/s");
  CHECK(again.Read(1).problem.points == one.Read(1).problem.points);
  CHECK(AllBytes(folder / "four/s").size() == before.size());
}

TEST_CASE("homographies, plain images, limits on pairs and matches") {
  TemporaryFolder folder;
  const std::string input = folder / "plane";
  fs::create_directory(input);
  const cv::Mat texture = Texture(320, 240, 8);
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> H;
  H << 0.97, -0.1, 20, 0.08, 1.01, -12, 1e-4, -5e-5, 1;
  cv::Mat warped;
  cv::warpPerspective(texture, warped, cv::Mat(3, 3, CV_64F, H.data()), texture.size());
  WriteImage(input + "/1.ppm", texture);
  WriteImage(input + "/2.ppm", warped);
  WriteImage(input + "/3.ppm", Texture(320, 240, 99));
  WriteRaw(input + "/H_1_2", Text(H));
  WriteRaw(input + "/H_1_3", Text(Eigen::Matrix3d::Identity()));
  PairsRequest request = Request("homographies", input, folder / "out");
  request.scene = "renamed";
  request.options.features.max_keypoints = 200;
  REQUIRE(RunPairs(request, kNeverStop).finished);
  {
    const CorrespondenceScene scene(folder / "out/renamed");
    REQUIRE(scene.pairs() == std::vector<std::string>{"1-2", "1-3"});
    CHECK(scene.Read(0).problem.points.rows() <= 200);
    CHECK(ShareNearTruth(scene.Read(0), 1.0) > 0.6);
    CHECK(ShareNearTruth(scene.Read(1), 1.0) < 0.1);
    CHECK(!scene.Read(0).problem.cameras);
  }
  // Images that have nothing in common are left out on demand.
  request.options.min_true_matches = 20;
  request.options.overwrite = true;
  REQUIRE(RunPairs(request, kNeverStop).finished);
  CHECK(CorrespondenceScene(folder / "out/renamed").pairs() == std::vector<std::string>{"1-2"});
  request.options.min_true_matches = 100000;
  CHECK(Has(ErrorOf([&] { RunPairs(request, kNeverStop); }), "no pair has enough"));
  // Or are the only ones that stay.
  request.options.min_true_matches = 0;
  request.options.true_share = {0.0, 0.3};
  REQUIRE(RunPairs(request, kNeverStop).finished);
  CHECK(CorrespondenceScene(folder / "out/renamed").pairs() == std::vector<std::string>{"1-3"});
  request.options.true_share = {0.3, 0.0};
  CHECK(Has(ErrorOf([&] { RunPairs(request, kNeverStop); }), "true_share"));

  PairsRequest plain = Request("images", input, folder / "out");
  plain.options.max_pairs = 2;
  REQUIRE(RunPairs(plain, kNeverStop).finished);
  const CorrespondenceScene scene(folder / "out/plane");
  REQUIRE(scene.pairs() == std::vector<std::string>{"1-2", "1-3"});
  CHECK(!scene.Read(0).truth.fundamental);
  CHECK(!scene.Read(0).truth.homography);
}

TEST_CASE("a request to stop leaves whole scenes only") {
  TemporaryFolder folder;
  WritePinhole(Views(), folder / "s");
  const std::atomic<bool> stop{true};
  CHECK(!RunPairs(Request("colmap", folder / "s", folder / "out"), stop).finished);
  CHECK(!fs::exists(folder / "out/s"));
}

TEST_CASE("mistakes of a request are named before the work") {
  TemporaryFolder folder;
  WriteKitti(Views(), folder / "kitti");
  const auto error = [&](auto change) {
    PairsRequest request = Request("kitti", folder / "kitti", folder / "out");
    change(request);
    return ErrorOf([&] { RunPairs(request, kNeverStop); });
  };
  CHECK(Has(error([](auto& r) { r.sequence = ""; }), "--sequence"));
  CHECK(Has(error([](auto& r) { r.format = "kity"; }), "unknown format 'kity'"));
  CHECK(Has(error([](auto& r) { r.scene = "x", r.choice.steps = {1, 2}; }), "2 scenes"));
  CHECK(Has(error([](auto& r) { r.options.max_pairs = -1; }), "max_pairs"));
  CHECK(Has(error([](auto& r) { r.options.true_match_px = 0; }), "true_match_px"));
  CHECK(Has(error([](auto& r) { r.input += "/nowhere"; }), "nowhere"));
  WriteRaw(folder / "file", "x");
  CHECK(Has(error([&](auto& r) { r.output = folder / "file/out"; }), "file"));
  CHECK(Has(error([](auto& r) { r.calibration.focal = 2; }), "has its own"));
  CHECK(Has(error([](auto& r) { r.format = "images"; }), "--sequence"));
  CHECK(Has(error([](auto& r) { r.options.import_descriptors = "nowhere.h5"; }), "nowhere.h5: no such file"));
}

TEST_CASE("broken images are left out, counted and named, the rest is done") {
  TemporaryFolder folder;
  WriteKitti(Views(), folder / "kitti");
  WriteRaw(folder / "kitti/sequences/07/image_0/000001.png", "broken");
  PairsRequest request = Request("kitti", folder / "kitti", folder / "out");
  request.choice.steps = {2, 1};
  // Both pairs at step 1 need the broken image: the other scene is written before that is said.
  const std::string text = ErrorOf([&] { RunPairs(request, kNeverStop); });
  CHECK(Has(text, "kitti_07_step_01: no pair of images that can be read"));
  CHECK(Has(text, "000001.png"));
  CHECK(!fs::exists(folder / "out/kitti_07_step_01"));
  CHECK(CorrespondenceScene(folder / "out/kitti_07_step_02").size() == 1);

  WritePinhole(Views(), folder / "s");
  WriteImage(folder / "s/images/0001.png", cv::Mat(100, 100, CV_8U, cv::Scalar(9)));
  const PrepareResult result = RunPairs(Request("colmap", folder / "s", folder / "out"), kNeverStop);
  CHECK(result.finished);
  CHECK(result.written == 1);
  REQUIRE(result.left_out.size() == 1);
  CHECK(Has(result.left_out[0], "0001.png: is 100x100, but its calibration is for 320x240"));
  CHECK(CorrespondenceScene(folder / "out/s").pairs() == std::vector<std::string>{"0000-0002"});
}

TEST_CASE("scenes that are there stay, and an interrupted preparation goes on with its keypoints") {
  TemporaryFolder folder;
  WriteKitti(Views(), folder / "kitti");
  const std::string output = folder / "out", images = folder / "kitti/sequences/07/image_0/";
  PairsRequest request = Request("kitti", folder / "kitti", output);
  request.choice.steps = {1, 2};
  REQUIRE(RunPairs(request, kNeverStop).written == 2);
  CHECK(!fs::exists(output + "/.keypoints-kitti_07_step_01"));
  const std::string before = AllBytes(output + "/kitti_07_step_01");
  const PointMatrix points = CorrespondenceScene(output + "/kitti_07_step_01").Read(1).problem.points;
  // One of two is gone.
  fs::remove(output + "/kitti_07_step_02/matches.h5");
  PrepareResult result = RunPairs(request, kNeverStop);
  CHECK((result.written == 1 && result.already_there == 1));
  CHECK(AllBytes(output + "/kitti_07_step_01") == before);
  result = RunPairs(request, kNeverStop);
  CHECK((result.written == 0 && result.already_there == 2));
  // Other options do not make it again by themselves, but on demand.
  request.options.features.max_keypoints = 50;
  CHECK(RunPairs(request, kNeverStop).written == 0);
  request.options.overwrite = true;
  CHECK(RunPairs(request, kNeverStop).written == 2);
  CHECK(CorrespondenceScene(output + "/kitti_07_step_01").Read(0).problem.points.rows() <= 50);

  // Nor does another list of as many pairs, but the scene's folder tells them apart.
  std::string recipes[2];
  for (int i = 0; i < 2; ++i) {
    PairsRequest listed = Request("kitti", folder / "kitti", folder / ("list" + std::to_string(i)));
    WriteFileAtomically(folder / "pairs.txt", i == 0 ? "000000 000001" : "000001 000002");
    listed.choice.pairs_file = folder / "pairs.txt";
    REQUIRE(RunPairs(listed, kNeverStop).written == 1);
    recipes[i] = ReadFile(listed.output + "/kitti_07/prepared.txt");
  }
  CHECK(recipes[0] != recipes[1]);

  // What an interruption leaves, and what is made of it. The last image is broken meanwhile: were its keypoints not
  // taken from their file, it would be left out.
  request.options = {};
  request.output = folder / "again";
  const ImageSource source = ReadKitti(request.input, "07", {1, {1, 2}});
  const FeatureCache cache(request.output + "/.keypoints-kitti_07_step_01", request.options.features);
  for (const SourceImage& image : source.images)
    cache.Write(image.name, image.path, ExtractRawFeatures(image.path, request.options.features));
  const std::string path = images + "000002.png", good = ReadFile(path);
  const auto time = fs::last_write_time(path);
  WriteRaw(path, std::string(good.size(), 'x'));
  fs::last_write_time(path, time);
  result = RunPairs(request, kNeverStop);
  CHECK(result.left_out.empty());
  CHECK(result.written == 2);
  CHECK(CorrespondenceScene(request.output + "/kitti_07_step_01").Read(1).problem.points == points);
  CHECK(!fs::exists(request.output + "/.keypoints-kitti_07_step_01"));
  // Without them, and with those of an older image, it is left out.
  request.options.overwrite = true;
  CHECK(ErrorOf([&] { RunPairs(request, kNeverStop); }).find("000002.png") != std::string::npos);
}

TEST_CASE("all kinds of features match the views, and their descriptors are stored") {
  TemporaryFolder folder;
  WritePinhole(Views(), folder / "s");
  for (FeatureKind kind : {FeatureKind::kSift, FeatureKind::kRootSift, FeatureKind::kOrb, FeatureKind::kXFeat}) {
    CAPTURE(ToString(kind));
    PairsRequest request = Request("colmap", folder / "s", folder / ToString(kind));
    request.options.features.kind = kind;
    request.options.descriptors = true;
    REQUIRE(RunPairs(request, kNeverStop).finished);
    CorrespondenceOptions options;
    options.descriptors = true;
    const CorrespondenceScene scene(folder / ToString(kind) + "/s", options);
    const Example pair = scene.Read(0);
    REQUIRE(pair.problem.points.rows() > 60);
    CHECK(ShareNearTruth(pair, 2.0) > 0.6);
    CHECK(pair.problem.snn_ratio.maxCoeff() <= 1.0);
    const DescriptorMatrix& rows = pair.problem.descriptors;
    if (kind == FeatureKind::kOrb) {
      CHECK(rows.cols() == 512);
      CHECK(((rows.array() == 0.0f) || (rows.array() == 1.0f)).all());
    } else {
      const Eigen::Index size = kind == FeatureKind::kXFeat ? 64 : 128;
      CHECK(rows.cols() == 2 * size);
      CHECK(pair.problem.scale_rotation_changes.rows() ==
            (kind == FeatureKind::kXFeat ? 0 : pair.problem.points.rows()));
      CHECK((rows.leftCols(size).rowwise().norm().array() - 1.0f).abs().maxCoeff() < 1e-5f);
    }
  }
}

}  // namespace diffsac
