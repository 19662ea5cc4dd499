#include "lab/images/estimate_photographs.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <sstream>

#include "core/temporary_folder.h"
#include "lab/colmap/database.h"
#include "lab/files/files.h"
#include "lab/images/image_test_util.h"
#include "lab/images/json_values.h"
#include "lab/images/match_pair.h"
#include "lab/images/photograph_results.h"

namespace diffsac {
namespace {

using Catch::Contains;
namespace fs = std::filesystem;

// Four views of a textured plane, and what a run on them needs.
struct Run {
  TemporaryFolder folder;
  std::string photos = folder / "photos", output = folder / "out";
  std::atomic<bool> stop{false};
  GivenCalibration calibration{"", 300.0, {}};
  PairOptions options{.guidance = Guidance::kNone, .seed = 5, .threads = 2};
  Photographs photographs;
  std::unique_ptr<FeatureStore> store;
  PhotographCameras cameras;
  std::vector<ImagePair> pairs;

  Run() {
    fs::create_directories(photos);
    LensCamera camera;
    camera.K << 300.0, 0.0, 159.5, 0.0, 300.0, 119.5, 0.0, 0.0, 1.0;
    const cv::Mat texture = Texture(900, 700, 3);
    for (int i = 0; i < 4; ++i)
      WriteImage(photos + "/v-" + std::to_string(i) + ".png", Render(texture, camera, NearbyPose(i), {320, 240}));
  }

  void Estimate() {
    photographs = ListPhotographs({photos}, "");
    std::vector<std::string> paths;
    for (const SourceImage& image : photographs.source.images) paths.push_back(image.path);
    store = std::make_unique<FeatureStore>(photographs.source, FeatureOptions(), "", output + "/.keypoints");
    fs::create_directories(output);
    REQUIRE(PreparePhotographs(ImageCameras(calibration, paths), 2, stop, store.get(), &photographs.source));
    std::vector<ImageSize> sizes;
    for (int i = 0; i < std::ssize(paths); ++i) sizes.push_back(store->SizeOf(i));
    cameras = CamerasOfPhotographs(photographs.source.images, sizes, false);
    pairs = EstimatePairs(photographs.source, *store, cameras, options, stop);
  }

  // What the run says.
  std::string Write() const {
    std::ostringstream out;
    WritePhotographResults({photographs, cameras, store.get(), options, output}, pairs, out);
    return out.str();
  }

  std::string Go() {
    Estimate();
    return Write();
  }
};

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// A line without its milliseconds.
std::string WithoutTimes(const std::string& line) {
  std::string kept;
  std::istringstream fields(line);
  int column = 0;
  for (std::string field; std::getline(fields, field, ','); ++column)
    if (column != 18 && column != 19) kept += field + ",";
  return kept;
}

// t had six digits in poses.csv.
TEST_CASE("photographs: of an image and its copy no motion is told, and no t") {
  Run run;
  for (const char* other : {"/v-2.png", "/v-3.png"}) fs::remove(run.photos + other);
  fs::copy_file(run.photos + "/v-0.png", run.photos + "/v-1.png", fs::copy_options::overwrite_existing);
  run.Go();
  const std::vector<std::string> lines = Lines(ReadFile(run.output + "/poses.csv"));
  REQUIRE(lines.size() == 2);
  CHECK(lines[1].find(",static,") != std::string::npos);
  std::vector<std::string> fields;
  std::istringstream line(lines[1]);
  for (std::string field; std::getline(line, field, ',');) fields.push_back(field);
  REQUIRE(fields.size() > 13);
  CHECK_FALSE(fields[6].empty());
  for (int i = 10; i < 13; ++i) CHECK(fields[i].empty());
}

TEST_CASE("photographs: every pair is what two images alone give, whatever the threads") {
  Run run;
  const std::string said = run.Go();
  const std::vector<ImagePair>& pairs = run.pairs;
  CHECK_THAT(said, Contains("photos: 6 pairs: 6 are sure, "));
  CHECK_THAT(said, Contains("colmap mapper --database_path " + run.output + "/database.db --image_path "));
  REQUIRE(pairs.size() == 6);
  ImagePair alone = MatchTwoImages(run.photos + "/v-1.png", run.photos + "/v-2.png", {}, run.calibration);
  EstimatePair(run.options, &alone);
  const auto same =
      std::find_if(pairs.begin(), pairs.end(), [](const ImagePair& pair) { return pair.example.id == "v_1-v_2"; });
  REQUIRE(same != pairs.end());
  CHECK(same->example.problem.points == alone.example.problem.points);
  CHECK(same->estimate.model == alone.estimate.model);
  CHECK(same->estimate.inliers == alone.estimate.inliers);

  const std::vector<std::string> lines = Lines(ReadFile(run.output + "/poses.csv"));
  REQUIRE(lines.size() == 7);
  CHECK(lines[0].ends_with(
      ",focal1_source,focal2_source,other_qw,other_qx,other_qy,other_qz,other_tx,other_ty,other_tz,"
      "camera1,camera2,focal1_low_px,focal1_high_px,focal2_low_px,focal2_high_px,focal1_observable,focal2_observable,"
      "verdict,focal_conflict"));
  CHECK(lines[1].starts_with("v-0.png,v-1.png,ok,0,none,5,"));
  // They show one plane, which two motions explain.
  CHECK(lines[1].find(",determined,given,given,0.") != std::string::npos);
  run.options.threads = 1;
  run.Go();
  const std::vector<std::string> again = Lines(ReadFile(run.output + "/poses.csv"));
  REQUIRE(again.size() == lines.size());
  for (std::size_t i = 1; i < lines.size(); ++i) CHECK(WithoutTimes(again[i]) == WithoutTimes(lines[i]));
}

TEST_CASE("photographs: the files agree with each other") {
  Run run;
  run.Go();
  const Json json = Json::parse(ReadFile(run.output + "/pairs.json"));
  const ColmapDatabase database(run.output + "/database.db");
  REQUIRE(json.at("pairs").size() == 6);
  CHECK(database.images().at(1).name == "v-0.png");
  CHECK(database.MatchedPairs().size() == 6);
  CHECK(database.MatchedPairs(true).size() == 6);
  // One camera took them all.
  CHECK(database.images().at(1).camera == database.images().at(4).camera);
  CHECK(database.CameraOf(1).parameters == std::vector<double>{300.0, 300.0, 160.0, 120.0});
  CHECK(database.CameraOf(1).has_prior_focal_length);
  for (const Json& said : json.at("pairs")) {
    const auto pair = std::find_if(run.pairs.begin(), run.pairs.end(),
                                   [&](const ImagePair& p) { return said.at("pair") == p.example.id; });
    REQUIRE(pair != run.pairs.end());
    CHECK(said.at("matches") == pair->example.problem.points.rows());
    CHECK(said.at("model")[5] == pair->estimate.model(1, 2));
    const std::int64_t id1 = pair->images[0] + 1, id2 = pair->images[1] + 1;
    const MatchIndices matches = database.Matches({id1, id2});
    CHECK(matches == pair->matches);
    CHECK(database.Matches({id1, id2}, true).rows() == pair->estimate.num_inliers);
    const PointMatrix keypoints = database.Keypoints(id1);
    CHECK((keypoints.row(matches(0, 0)).array() - 0.5 - pair->example.problem.points.row(0).leftCols<2>().array())
              .abs()
              .maxCoeff() < 1e-4);
  }
}

TEST_CASE("photographs: an image that cannot be read is left out, and one of another size than its camera") {
  Run run;
  WriteFileAtomically(run.photos + "/text.jpg", "no image");
  // Of the same name but for its extension: those that are left are named by the database.
  WriteFileAtomically(run.photos + "/v-0.jpg", "no image");
  CHECK_THAT(run.Go(), Contains("photos: 6 pairs: 6 are sure, "));
  CHECK_THAT(ReadFile(run.output + "/poses.csv"), Contains("v-0.png,v-1.png,ok"));
  run.calibration = {};
  run.calibration.cameras = run.folder / "cameras.txt";
  WriteFileAtomically(run.calibration.cameras, "1 SIMPLE_RADIAL 320 240 300 160 120 -0.05\n");
  WriteImage(run.photos + "/v-3.png", Texture(200, 240, 1));
  const std::string said = run.Go();
  CHECK_THAT(said, Contains("photos: 3 pairs: 3 are sure, "));
  CHECK_THAT(said, Contains("\n  3 images belong together: v-0.png, v-1.png, v-2.png\n  /"));
  for (const ImagePair& pair : run.pairs) CHECK(pair.example.image2 != "v_3");
  CHECK(ColmapDatabase(run.output + "/database.db").CameraOf(1).parameters ==
        std::vector<double>{300.0, 160.0, 120.0, -0.05});
}

TEST_CASE("photographs: without a calibration the cameras of the database are guesses") {
  Run run;
  run.calibration = {};
  run.options.task = Task::kFundamental;
  run.options.max_iterations = 50;
  run.options.min_iterations = 0;
  run.Go();
  const ColmapDatabase database(run.output + "/database.db");
  CHECK_FALSE(database.CameraOf(1).has_prior_focal_length);
  CHECK(database.CameraOf(1).parameters == std::vector<double>{384.0, 160.0, 120.0, 0.0});
  CHECK(database.images().at(1).camera != database.images().at(2).camera);
}

TEST_CASE("photographs: what was done before an interruption is kept") {
  Run run;
  run.Estimate();
  run.pairs[1].done = run.pairs[4].done = false;
  run.Write();
  CHECK(Lines(ReadFile(run.output + "/poses.csv")).size() == 5);
  CHECK(Json::parse(ReadFile(run.output + "/pairs.json")).at("partial").get<bool>());
  run.stop = true;
  const auto none = EstimatePairs(run.photographs.source, *run.store, run.cameras, run.options, run.stop);
  CHECK(std::none_of(none.begin(), none.end(), [](const ImagePair& pair) { return pair.done; }));
}

}  // namespace
}  // namespace diffsac
