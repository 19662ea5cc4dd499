// Matches of one pair and of many that something else made.

#include "lab/images/given_matches.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <filesystem>

#include "core/temporary_folder.h"
#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/problem/tasks.h"
#include "guidance/captured_log.h"
#include "lab/colmap/database.h"
#include "lab/colmap/two_view_geometries.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;

const GivenCalibration kCalibration{"", 300.0, {159.5, 119.5}};

std::string Rows(int count, const std::string& more = "") {
  Rng rng(5);
  std::string text;
  for (int i = 0; i < count; ++i) {
    for (int c = 0; c < 4; ++c) text += std::to_string(rng.Uniform(0.0, 300.0)) + " ";
    text += more + "\n";
  }
  return text;
}

TEST_CASE("matches outside the given sizes are an error") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("m.txt"), Rows(20));
  CHECK_THROWS_WITH(ReadMatches({folder.File("m.txt"), {{300, 300}, {100, 75}}}, {}),
                    Contains("m.txt: the size of image 2: expected (width, height)"));
  CHECK_NOTHROW(ReadMatches({folder.File("m.txt"), {{300, 300}}}, {}));
}

TEST_CASE("columns that are not read are named") {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& header) {
    const std::string file = folder.File(header.substr(0, header.find(' ')) + ".csv");
    WriteFileAtomically(file, header + "\n" + Rows(9, "0.5"));
    return CapturedLog([&] { ReadMatches({file, {}}, {}); });
  };
  CHECK(said("x1 y1 x2 y2 score").empty());
  CHECK_THAT(said("y1 x1 y2 x2 confidence"), Contains("not read: 'confidence'; names that would be: 'ratio', "));
}

TEST_CASE("a folder of matches is a folder of pairs, bad files are left out, and what only some have") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("a-b.txt"), Rows(20, "0.5"));
  WriteFileAtomically(folder.File("b-c.csv"), Rows(12));
  WriteFileAtomically(folder.File("wall.txt"), Rows(8, "0.5"));
  WriteFileAtomically(folder.File("wall.csv"), Rows(9));
  WriteFileAtomically(folder.File("bad.txt"), "1 2 3\n");
  WriteFileAtomically(folder.File("notes.md"), "no matches");
  REQUIRE(AreManyMatches(folder.path()));
  const GivenPairs given = ReadManyMatches({folder.path(), {{320, 300}}}, kCalibration, true);
  REQUIRE(given.set.pairs.size() == 3);
  CHECK(given.set.pairs[0].id == "a-b");
  CHECK(given.set.pairs[0].image2 == "b");
  CHECK(given.set.pairs[2].id == "wall");
  CHECK(given.set.pairs[2].image1.empty());
  for (const Example& pair : given.set.pairs) {
    CHECK(pair.problem.snn_ratio.size() == 0);
    CHECK(pair.problem.size2.width == 320);
    REQUIRE(pair.problem.cameras);
    CHECK(pair.problem.cameras->K1(0, 0) == 300.0);
  }
  const GivenPhotographs photographs = PhotographsOf(given, "folder");
  CHECK(photographs.photographs.files == std::vector<std::string>{"a", "b", "c", "", ""});
  CHECK(photographs.sizes[4].width == 320);
  CHECK(photographs.pairs[0].images[1] == photographs.pairs[1].images[0]);
  CHECK(photographs.pairs[2].images == std::array<int, 2>{3, 4});
}

TEST_CASE("folders without matches, and of bad ones alone, are named") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(ReadManyMatches({folder.path(), {}}, {}, true), Contains("expected files of matches"));
  WriteFileAtomically(folder.File("bad.txt"), "1 2 3\n");
  CHECK_THROWS_WITH(ReadManyMatches({folder.path(), {}}, {}, true), Contains("bad.txt:1: expected 4 to 8 columns"));
  CHECK_THROWS_WITH(ReadManyMatches({folder.File("none.db"), {}}, {}, true), Contains("none.db"));
  CHECK_THROWS_WITH(ReadManyMatches({folder.File("none.h5"), {}}, {}, true), Contains("none.h5: no such file"));
  CHECK_FALSE(AreManyMatches(folder.File("bad.txt")));
}

/// Three images of two cameras, of which the first has a prior focal length; pairs 1-2 and 2-3.
NewColmapDatabase Database() {
  NewColmapDatabase database;
  const int model = ColmapModelNumber("PINHOLE").value();
  for (const bool prior : {true, false}) {
    ColmapCamera camera;
    camera.model = model;
    camera.size = {320, 240};
    camera.parameters = {300.0, 300.0, 160.0, 120.0};
    camera.has_prior_focal_length = prior;
    database.cameras.push_back(camera);
  }
  Rng rng(3);
  for (int i = 0; i < 3; ++i) {
    PointMatrix points(30, 2);
    for (Eigen::Index k = 0; k < points.size(); ++k) points.data()[k] = rng.Uniform(0.5, 200.0);
    database.images.push_back({"v-" + std::to_string(i) + ".jpg", i < 2 ? 0u : 1u, points, PointMatrix::Zero(30, 2)});
  }
  MatchIndices matches(30, 2);
  for (int i = 0; i < 30; ++i) matches.row(i) << i, 29 - i;
  database.matches[{1, 2}] = database.matches[{2, 3}] = matches;
  return database;
}

TEST_CASE("a COLMAP database: calibrated pairs, all pairs, the calibration that is given, verified matches") {
  const TemporaryFolder folder;
  const std::string path = folder.File("some.db");
  CreateColmapDatabase(path, Database());
  REQUIRE(AreManyMatches(path));
  GivenPairs given = ReadManyMatches({path, {}}, {}, true);
  REQUIRE(given.set.pairs.size() == 1);
  CHECK(given.of_others == 1);
  CHECK(given.files.at(given.set.pairs[0].image1) == "v-0.jpg");
  REQUIRE(given.set.pairs[0].problem.cameras);
  CHECK(given.set.pairs[0].problem.cameras->K1(0, 2) == 159.5);
  CHECK(given.set.match_indices.at(0)(0, 1) == 29);
  given = ReadManyMatches({path, {}}, {}, false);
  REQUIRE(given.set.pairs.size() == 2);
  CHECK_FALSE(given.set.pairs[0].problem.cameras);
  CHECK(given.set.pairs[0].problem.size1.width == 320);
  given = ReadManyMatches({path, {}}, kCalibration, true);
  REQUIRE(given.set.pairs.size() == 2);
  CHECK(given.set.pairs[1].problem.cameras->K2(0, 0) == 300.0);

  NewColmapDatabase verified = Database();
  const MatchIndices matches = verified.matches.begin()->second;
  verified.matches.clear();
  const std::string second = folder.File("verified.db");
  CreateColmapDatabase(second, verified);
  CHECK_THROWS_WITH(ReadManyMatches({second, {}}, {}, true), Contains("holds no matches"));
  {
    const ColmapDatabase database(second, SqliteDatabase::Access::kWrite);
    ColmapGeometry geometry;
    geometry.pair = {1, 2};
    geometry.configuration = ColmapConfiguration::kUncalibrated;
    geometry.inliers = matches.topRows(20);
    WriteGeometries(database, {geometry}, false);
  }
  given = ReadManyMatches({second, {}}, {}, true);
  REQUIRE(given.set.pairs.size() == 1);
  CHECK(given.set.pairs[0].problem.points.rows() == 20);
}

TEST_CASE("points of a known scene: x y X Y Z by place, or by name, with a calibration") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("points.txt"), "10 20 1 2 3 0.5\n30 40 4 5 6 0.25\n");
  const Problem problem = ReadScenePoints({folder.File("points.txt"), {}}, kCalibration).example.problem;
  CHECK(problem.task == Task::kAbsolutePose);
  CHECK(problem.points.row(1) == Eigen::Matrix<double, 1, 5>(4, 5, 6, 30, 40));
  CHECK(problem.snn_ratio[1] == 0.25);
  WriteFileAtomically(folder.File("named.csv"), "z,y,x,v,u\n3,2,1,20,10\n");
  const Problem named = ReadScenePoints({folder.File("named.csv"), {}}, kCalibration).example.problem;
  CHECK(named.points.row(0) == Eigen::Matrix<double, 1, 5>(1, 2, 3, 10, 20));
  WriteFileAtomically(folder.File("few.txt"), "10 20 1 2\n");
  CHECK_THROWS_WITH(ReadScenePoints({folder.File("few.txt"), {}}, kCalibration),
                    Contains("few.txt:1: expected 5 to 7 columns, found 4"));
  CHECK_THROWS_WITH(ReadScenePoints({folder.File("points.txt"), {}}, {}), Contains("needs --calibration"));
  CHECK_THROWS_WITH(ReadScenePoints({folder.File("points.txt"), {}}, {"", 300.0, {}}),
                    Contains("give --sizes, or --center"));
}

}  // namespace
}  // namespace diffsac
