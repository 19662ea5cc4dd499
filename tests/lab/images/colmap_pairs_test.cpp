#include <catch2/catch.hpp>

#include <filesystem>

#include "core/errors.h"
#include "lab/colmap/colmap_test_util.h"
#include "lab/colmap/lens.h"
#include "lab/files/correspondence_files.h"
#include "lab/images/run_pairs.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

const std::atomic<bool> kNeverStop{false};

PointMatrix Grid(int count, double step) {
  PointMatrix points(count, 2);
  for (int i = 0; i < count; ++i) points.row(i) << 20.0 + step * (i % 6), 30.5 + 1.5 * step * (i / 6);
  return points;
}

PairsRequest RequestFor(const TemporaryFolder& folder) {
  PairsRequest request;
  request.format = "colmap_database";
  request.input = folder / "photos.db";
  request.output = folder / "pairs";
  return request;
}

// Three images of two cameras; the second one's focal length is COLMAP's guess unless `known`.
void FillThree(DatabaseMaker* maker, bool known) {
  maker->AddCamera(1, 2, {500, 320, 240, -0.2});
  maker->AddCamera(2, 1, {400, 410, 100, 90}, known, {200, 180});
  maker->AddImage(1, "a-1.jpg");
  maker->AddImage(2, "sub/b.jpg");
  maker->AddImage(3, "c.jpg", 2);
  maker->AddKeypoints(1, Grid(30, 70.0));
  maker->AddKeypoints(2, Grid(30, 60.0));
  maker->AddKeypoints(3, Grid(30, 10.0));
  maker->AddMatches({1, 2}, Crossed(30));
  maker->AddMatches({1, 3}, Crossed(25));
}

}  // namespace

TEST_CASE("pairs of a COLMAP database: our pixels without distortion, K, sizes, keypoints") {
  TemporaryFolder folder;
  DatabaseMaker maker(folder / "photos.db");
  FillThree(&maker, true);
  CHECK(RunPairs(RequestFor(folder), kNeverStop).written == 1);
  const CorrespondenceScene scene(folder / "pairs/photos");
  REQUIRE(scene.pairs() == std::vector<std::string>{"a_1-c", "a_1-sub_b"});
  const Example pair = scene.Read(1);
  const Problem& problem = pair.problem;
  CHECK(problem.size1 == ImageSize{640, 480});
  CHECK(scene.Read(0).problem.size2 == ImageSize{200, 180});
  CHECK(problem.snn_ratio.size() == 0);
  REQUIRE(problem.cameras);
  CHECK(problem.cameras->K1 == (Eigen::Matrix3d() << 500, 0, 319.5, 0, 500, 239.5, 0, 0, 1).finished());
  CHECK(scene.ReadMatchIndices("a_1-sub_b", 30) == Crossed(30));
  const ColmapLens lens({2, {640, 480}, {500, 320, 240, -0.2}}, "");
  const PointMatrix seen1 = Grid(30, 70.0), seen2 = Grid(30, 60.0);
  for (int i = 0; i < 30; ++i) {
    CHECK((lens.Distort(problem.points.block<1, 2>(i, 0).transpose()).transpose().array() + 0.5 - seen1.row(i).array())
              .matrix()
              .norm() < 1e-4);
    CHECK((lens.Distort(problem.points.block<1, 2>(i, 2).transpose()).transpose().array() + 0.5 -
           seen2.row(29 - i).array())
              .matrix()
              .norm() < 1e-4);
  }
  CHECK(Has(ErrorOf([&] { scene.ReadMatchIndices("a_1-sub_b", 29); }),
            "match_indices.h5: a_1-sub_b: expected 29x2, found 30x2"));
  // What is there stays, and is made again when that is asked for.
  CHECK(RunPairs(RequestFor(folder), kNeverStop).already_there == 1);
  PairsRequest again = RequestFor(folder);
  again.options.overwrite = true;
  CHECK(RunPairs(again, kNeverStop).written == 1);
}

TEST_CASE("pairs of a COLMAP database: a guessed focal length is no calibration") {
  TemporaryFolder folder;
  DatabaseMaker maker(folder / "photos.db");
  FillThree(&maker, false);
  CHECK(RunPairs(RequestFor(folder), kNeverStop).written == 2);
  const CorrespondenceScene known(folder / "pairs/photos_calibrated"), unknown(folder / "pairs/photos_uncalibrated");
  CHECK(known.pairs() == std::vector<std::string>{"a_1-sub_b"});
  CHECK(known.Read(0).problem.cameras);
  REQUIRE(unknown.pairs() == std::vector<std::string>{"a_1-c"});
  CHECK_FALSE(unknown.Read(0).problem.cameras);
  // Where they are seen, whatever the other image's calibration.
  CHECK(unknown.Read(0).problem.points(0, 0) == Approx(19.5));
  maker.Run("UPDATE cameras SET prior_focal_length = 0");
  PairsRequest request = RequestFor(folder);
  request.scene = "all";
  CHECK(RunPairs(request, kNeverStop).written == 1);
  CHECK(CorrespondenceScene(folder / "pairs/all").size() == 2);
}

TEST_CASE("pairs of a COLMAP database: ratios from descriptors, where they are asked for") {
  TemporaryFolder folder;
  DatabaseMaker maker(folder / "photos.db");
  maker.AddCamera(1, 0, {500, 320, 240});
  maker.AddImage(1, "a.jpg");
  maker.AddImage(2, "b.jpg");
  maker.AddKeypoints(1, Grid(2, 50.0));
  maker.AddKeypoints(2, Grid(3, 50.0));
  maker.AddMatches({1, 2}, Crossed(2));
  PairsRequest request = RequestFor(folder);
  request.ratios = true;
  CHECK(Has(ErrorOf([&] { RunPairs(request, kNeverStop); }), "image 'a.jpg' has no descriptors"));
  ColmapDescriptors first = ColmapDescriptors::Zero(2, 128), second = ColmapDescriptors::Zero(3, 128);
  first(0, 0) = first(1, 1) = 100;
  second(0, 1) = 100;                 // that of keypoint 1: its match
  second(1, 0) = second(1, 2) = 100;  // 45° from keypoint 0: its match
  second(2, 0) = 100;                 // its nearest, which was not matched
  maker.AddDescriptors(1, first);
  maker.AddDescriptors(2, second);
  REQUIRE(RunPairs(request, kNeverStop).finished);
  const Problem problem = CorrespondenceScene(folder / "pairs/photos").Read(0).problem;
  REQUIRE(problem.snn_ratio.size() == 2);
  CHECK(problem.snn_ratio[0] == 1.0);
  CHECK(problem.snn_ratio[1] == Approx(0.0).margin(1e-6));
  request.format = "images";
  CHECK(Has(ErrorOf([&] { RunPairs(request, kNeverStop); }), "--ratios is not for images"));
}

TEST_CASE("pairs of a COLMAP database: rays that no pinhole camera sees are left out") {
  TemporaryFolder folder;
  DatabaseMaker maker(folder / "photos.db");
  maker.AddCamera(1, 5, {150, 150, 320, 240, 0, 0, 0, 0});
  maker.AddImage(1, "a.jpg");
  maker.AddImage(2, "b.jpg");
  PointMatrix points(3, 2);
  points << 320, 240, 2, 2, 400, 300;  // the second is seen at more than 90°
  maker.AddKeypoints(1, points);
  maker.AddKeypoints(2, points);
  maker.AddMatches({1, 2}, (MatchIndices(3, 2) << 0, 2, 1, 0, 2, 0).finished());
  REQUIRE(RunPairs(RequestFor(folder), kNeverStop).finished);
  const CorrespondenceScene scene(folder / "pairs/photos");
  CHECK(scene.Read(0).problem.points.rows() == 2);
  CHECK(scene.ReadMatchIndices("a-b", 2) == (MatchIndices(2, 2) << 0, 2, 2, 0).finished());
}

TEST_CASE("pairs of a COLMAP database: a bad image or pair costs no other, and 2016's databases are read") {
  TemporaryFolder folder;
  DatabaseMaker maker(folder / "photos.db");
  FillThree(&maker, true);
  PairsRequest request = RequestFor(folder);
  request.options.overwrite = true;
  const auto pairs = [&] {
    RunPairs(request, kNeverStop);
    return CorrespondenceScene(folder / "pairs/photos").pairs();
  };
  maker.Run("UPDATE cameras SET model = 99 WHERE camera_id = 2");
  CHECK(pairs() == std::vector<std::string>{"a_1-sub_b"});
  maker.Run("UPDATE cameras SET model = 1 WHERE camera_id = 2");
  maker.Run("UPDATE matches SET cols = 1, rows = 60 WHERE rows = 30");
  CHECK(pairs() == std::vector<std::string>{"a_1-c"});
  maker.Run("UPDATE matches SET cols = 2, rows = 30 WHERE rows = 60");
  maker.Run("ALTER TABLE two_view_geometries RENAME TO inlier_matches");
  for (const char* column : {"F", "E", "H", "qvec", "tvec"})
    maker.Run("ALTER TABLE inlier_matches DROP COLUMN " + std::string(column));
  CHECK(pairs().size() == 2);
  maker.Run("ALTER TABLE cameras DROP COLUMN prior_focal_length");
  CHECK(pairs().size() == 2);
  CHECK_FALSE(CorrespondenceScene(folder / "pairs/photos").Read(0).problem.cameras);
}

TEST_CASE("pairs of a COLMAP database: mistakes write nothing") {
  TemporaryFolder folder;
  DatabaseMaker maker(folder / "photos.db");
  FillThree(&maker, true);
  const auto error = [&] { return ErrorOf([&] { RunPairs(RequestFor(folder), kNeverStop); }); };
  maker.Run("UPDATE cameras SET model = 99 WHERE camera_id = 2");
  maker.Run("DELETE FROM matches WHERE pair_id = " + std::to_string(PairId({1, 2})));
  CHECK(Has(error(), "photos.db: camera of image 'c.jpg': unknown camera model 99"));
  maker.Run("UPDATE cameras SET model = 4 WHERE camera_id = 2");
  CHECK(Has(error(), "expected 8 parameters for OPENCV, found 4"));
  maker.Run("UPDATE matches SET rows = 0, data = x''");
  CHECK(Has(error(), "photos.db: it holds no matches"));
  CHECK_FALSE(fs::exists(folder / "pairs/photos/matches.h5"));
  PairsRequest request = RequestFor(folder);
  request.choice.every = 2;
  CHECK(Has(ErrorOf([&] { RunPairs(request, kNeverStop); }), "cannot be chosen"));
  request = RequestFor(folder);
  request.calibration.focal = 500;
  CHECK(Has(ErrorOf([&] { RunPairs(request, kNeverStop); }), "has its own"));
}

}  // namespace diffsac
