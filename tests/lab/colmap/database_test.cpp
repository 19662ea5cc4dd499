#include "lab/colmap/database.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "core/errors.h"
#include "lab/colmap/colmap_test_util.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

PointMatrix SomePoints(int count, double first) {
  PointMatrix points(count, 2);
  for (int i = 0; i < count; ++i) points.row(i) << first + i, 2.5 * i + 0.25;
  return points;
}

// Three images, of which 1-2 and 2-3 were matched, 1-3 without success.
void FillSmall(DatabaseMaker* maker) {
  maker->AddCamera(1, 2, {500, 320, 240, 0.1});
  maker->AddCamera(2, 1, {400, 410, 100, 90}, false, {200, 180});
  maker->AddImage(1, "a.jpg");
  maker->AddImage(2, "sub/b-c.jpg", 2);
  maker->AddImage(3, "d.png");
  maker->AddKeypoints(1, SomePoints(5, 10.0), 2);
  maker->AddKeypoints(2, SomePoints(6, 20.0), 4);
  maker->AddKeypoints(3, SomePoints(7, 30.0));
  maker->AddDescriptors(1, ColmapDescriptors::Constant(5, 128, 3));
  maker->AddMatches({1, 2}, Crossed(4));
  maker->AddMatches({2, 3}, Crossed(6));
  maker->AddMatches({1, 3}, MatchIndices(0, 2));
}

// What reading everything says of a small database that `spoil` has changed.
template <class Spoil>
std::string Spoiled(Spoil spoil) {
  TemporaryFolder folder;
  {
    DatabaseMaker maker(folder / "d.db");
    FillSmall(&maker);
    spoil(&maker);
  }
  return ErrorOf([&] {
    const ColmapDatabase database(folder / "d.db");
    for (const auto& [id, image] : database.images()) {
      database.Keypoints(id);
      database.Descriptors(id);
    }
    for (const ColmapPair& pair : database.MatchedPairs()) database.Matches(pair);
  });
}

auto Sql(const std::string& sql) {
  return [sql](DatabaseMaker* maker) { maker->Run(sql); };
}

}  // namespace

TEST_CASE("colmap database: scale and orientation of keypoints, of both forms, unless all are the same") {
  TemporaryFolder folder;
  DatabaseMaker maker(folder / "d.db");
  maker.AddCamera(1, 2, {500, 320, 240, 0.1});
  for (int image = 1; image <= 4; ++image) maker.AddImage(image, std::to_string(image) + ".jpg");
  Eigen::MatrixXd similar(2, 2), affine(2, 4), imported(2, 4), broken(2, 2);
  similar << 3.0, 0.5, 2.0, -1.0;
  // a11 a12 a21 a22: turned by 0.5, twice as large; stretched along x alone.
  affine << 2.0 * std::cos(0.5), -2.0 * std::sin(0.5), 2.0 * std::sin(0.5), 2.0 * std::cos(0.5), 3.0, 0.0, 0.0, 1.0;
  imported << 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0;
  broken << 0.0, 0.5, 2.0, 1.0;
  maker.AddKeypoints(1, SomePoints(2, 10.0), 4, similar);
  maker.AddKeypoints(2, SomePoints(2, 10.0), 6, affine);
  maker.AddKeypoints(3, SomePoints(2, 10.0), 6, imported);
  maker.AddKeypoints(4, SomePoints(2, 10.0), 4, broken);
  const ColmapDatabase database(folder / "d.db");
  const PointMatrix first = database.KeypointFrames(1), second = database.KeypointFrames(2);
  REQUIRE((first.rows() == 2 && second.rows() == 2));
  CHECK(first(0, 0) == Approx(std::log(3.0)));
  CHECK(first(0, 1) == Approx(0.5));
  CHECK(first(1, 1) == Approx(-1.0));
  CHECK(second(0, 0) == Approx(std::log(2.0)));
  CHECK(second(0, 1) == Approx(0.5));
  CHECK(second(1, 0) == Approx(std::log(2.0)));
  CHECK(second(1, 1) == 0.0);
  CHECK(database.KeypointFrames(3).rows() == 0);
  CHECK(database.KeypointFrames(4).rows() == 0);
}

TEST_CASE("colmap database: cameras, images, keypoints, descriptors, matches") {
  TemporaryFolder folder;
  DatabaseMaker maker(folder / "d.db");
  FillSmall(&maker);
  const ColmapDatabase database(folder / "d.db");
  REQUIRE(database.images().size() == 3);
  CHECK(database.images().at(2).name == "sub/b-c.jpg");
  CHECK(database.CameraOf(1).model == 2);
  CHECK(database.CameraOf(1).parameters == std::vector<double>{500, 320, 240, 0.1});
  CHECK(database.CameraOf(1).has_prior_focal_length);
  CHECK_FALSE(database.CameraOf(2).has_prior_focal_length);
  CHECK(database.CameraOf(2).size == ImageSize{200, 180});
  CHECK(database.Keypoints(1).isApprox(SomePoints(5, 10.0)));
  CHECK(database.Keypoints(2).isApprox(SomePoints(6, 20.0)));
  CHECK(database.Keypoints(3).isApprox(SomePoints(7, 30.0)));
  CHECK(database.KeypointFrames(1).rows() == 0);
  CHECK(database.Descriptors(1).rows() == 5);
  CHECK(database.Descriptors(1)(4, 127) == 3);
  CHECK(database.Descriptors(2).rows() == 0);
  CHECK(database.MatchedPairs() == std::vector<ColmapPair>{{1, 2}, {2, 3}});
  CHECK(database.Matches({1, 2}) == Crossed(4));
  CHECK(database.Matches({1, 3}).rows() == 0);
}

TEST_CASE("colmap database: numbers of pairs") {
  CHECK(PairId({1, 2}) == 2147483649);
  for (const ColmapPair& pair : {ColmapPair{1, 2}, ColmapPair{7, 2147483646}, ColmapPair{2147483645, 2147483646}})
    CHECK(PairOfId(PairId(pair)) == pair);
}

TEST_CASE("colmap database: names for pairs") {
  const auto names =
      PairNames({{1, "a.jpg"}, {2, "cam-1/b.c.png"}, {3, "x/a.jpg"}, {4, "a.png"}, {5, ".hidden"}, {6, "d"}});
  CHECK(names.at(1) == "a_1");
  CHECK(names.at(2) == "cam_1_b.c");
  CHECK(names.at(3) == "x_a");
  CHECK(names.at(4) == "a_4");
  CHECK(names.at(5) == ".hidden");
  CHECK(names.at(6) == "d");
  CHECK(Has(ErrorOf([] { PairNames({{1, "a.jpg"}, {4, "a.png"}, {7, "a_1.jpg"}}); }), "cannot be told apart"));
}

TEST_CASE("colmap database: files that are none") {
  TemporaryFolder folder;
  const auto error = [&](const char* name) { return ErrorOf([&] { ColmapDatabase(folder / name); }); };
  CHECK(Has(error("absent.db"), "absent.db: no such file"));
  CHECK(Has(ErrorOf([&] { ColmapDatabase(folder / ""); }), "no such file"));
  WriteRaw(folder / "text.db",
           "This is a text, and a long one, so that nobody takes it for the header of a database file.");
  CHECK(Has(error("text.db"), "text.db: not an SQLite database"));
  WriteRaw(folder / "empty.db", "");
  CHECK(Has(error("empty.db"), "no database of COLMAP: it has no table 'cameras'"));
}

TEST_CASE("colmap database: truncated") {
  TemporaryFolder folder;
  {
    DatabaseMaker maker(folder / "d.db");
    FillSmall(&maker);
    maker.AddImage(4, "large.jpg");
    maker.AddKeypoints(4, SomePoints(20000, 0.0));
  }
  for (const double share : {0.02, 0.5, 0.95}) {
    const auto size = fs::file_size(folder / "d.db");
    fs::copy_file(folder / "d.db", folder / "cut.db", fs::copy_options::overwrite_existing);
    fs::resize_file(folder / "cut.db", static_cast<std::uintmax_t>(share * static_cast<double>(size)));
    const std::string error = ErrorOf([&] { ColmapDatabase(folder / "cut.db").Keypoints(4); });
    INFO(share << " " << error);
    CHECK((Has(error, "damaged or truncated") || Has(error, "not an SQLite database")));
  }
}

TEST_CASE("colmap database: locked") {
  TemporaryFolder folder;
  DatabaseMaker maker(folder / "d.db");
  FillSmall(&maker);
  maker.Run("BEGIN EXCLUSIVE");
  CHECK(Has(ErrorOf([&] { ColmapDatabase(folder / "d.db"); }), "d.db: locked by another program"));
  maker.Run("ROLLBACK");
  CHECK(ColmapDatabase(folder / "d.db").images().size() == 3);
}

TEST_CASE("colmap database: in a folder that cannot be written") {
  TemporaryFolder folder;
  fs::create_directory(folder / "fixed ?#%");
  const std::string path = folder / "fixed ?#%/d.db";
  {
    DatabaseMaker maker(path);
    FillSmall(&maker);
    maker.Run("PRAGMA journal_mode=WAL");
  }
  fs::permissions(folder / "fixed ?#%", fs::perms::owner_read | fs::perms::owner_exec);
  CHECK(ColmapDatabase(path).images().size() == 3);
  fs::permissions(folder / "fixed ?#%", fs::perms::owner_all);
}

TEST_CASE("colmap database: another schema, missing rows") {
  CHECK(Spoiled(Sql("SELECT 1")) == "");
  CHECK(Has(Spoiled(Sql("DROP TABLE matches")), "no table 'matches'"));
  CHECK(Has(Spoiled(Sql("ALTER TABLE images DROP COLUMN camera_id")), "table 'images' has no column 'camera_id'"));
  // Reading needs none of it; writing does.
  CHECK(Spoiled(Sql("ALTER TABLE two_view_geometries DROP COLUMN qvec")) == "");
  TemporaryFolder folder;
  DatabaseMaker maker(folder / "d.db");
  FillSmall(&maker);
  maker.Run("ALTER TABLE two_view_geometries DROP COLUMN qvec");
  CHECK(Has(ErrorOf([&] { ColmapDatabase(folder / "d.db", SqliteDatabase::Access::kWrite); }),
            "table 'two_view_geometries' has no column 'qvec': expected a database of COLMAP 3.8 or later"));
  CHECK(Has(Spoiled(Sql("DELETE FROM images")), "it holds no images"));
  CHECK(Has(Spoiled(Sql("DELETE FROM cameras")), "there is no camera 1"));
  // What is missing costs its own images and pairs.
  CHECK(Spoiled(Sql("DELETE FROM cameras WHERE camera_id = 2")) == "");
  CHECK(Spoiled(Sql("DELETE FROM images WHERE image_id = 3")) == "");
  CHECK(Spoiled(Sql("UPDATE cameras SET params = x'0011'")) == "");
}

TEST_CASE("colmap database: values that contradict each other") {
  CHECK(Has(Spoiled(Sql("UPDATE keypoints SET rows = 4 WHERE image_id = 1")),
            "keypoints of image 'a.jpg': expected 4 x 2 values of 4 bytes, found 40 bytes"));
  CHECK(Has(Spoiled(Sql("UPDATE keypoints SET rows = -1")), "expected -1 x 2"));
  CHECK(Has(Spoiled(Sql("UPDATE keypoints SET rows = 4611686018427387904, cols = 4")),
            "expected 4611686018427387904 x 4"));
  CHECK(Has(Spoiled(Sql("UPDATE keypoints SET rows = 10, cols = 1 WHERE image_id = 1")), "expected x y and more"));
  CHECK(Has(Spoiled(Sql("DELETE FROM keypoints WHERE image_id = 2")),
            "matches of image 'a.jpg' and image 'sub/b-c.jpg': keypoint 3 of image 'sub/b-c.jpg', which has none"));
  CHECK(Has(Spoiled([](DatabaseMaker* maker) {
              maker->Run("DELETE FROM matches");
              maker->AddMatches({1, 2}, Crossed(6));
            }),
            "keypoint 5 of image 'a.jpg', which has 5"));
  CHECK(Has(Spoiled(Sql("UPDATE matches SET rows = 8, cols = 1 WHERE rows = 4")), "expected two keypoints a row"));
  CHECK(Has(Spoiled(Sql("UPDATE matches SET data = NULL WHERE rows = 4")), "found 0 bytes"));
  CHECK(Has(Spoiled(Sql("UPDATE descriptors SET rows = 128, cols = 5")),
            "descriptors of image 'a.jpg': 128 rows, but 5 keypoints"));
}

namespace {

NewColmapDatabase Small() {
  NewColmapDatabase content;
  content.cameras = {{2, {640, 480}, {500, 320, 240, 0.1}, true}, {1, {200, 180}, {240, 240, 100, 90}, false}};
  PointMatrix keypoints(3, 2), frames(3, 2);
  keypoints << 10.5, 20.25, 30, 40, 50, 60;
  frames << std::log(3.0), 0.5, std::log(2.0), -1.0, 0.0, 0.0;
  content.images = {{"a.jpg", 0, keypoints, frames}, {"sub/it's.jpg", 1, keypoints, frames}};
  content.matches[{1, 2}] = Crossed(3);
  return content;
}

TEST_CASE("a new COLMAP database reads back as it was written") {
  TemporaryFolder folder;
  const std::string path = folder / "new.db";
  WriteRaw(path, "an older file");
  CreateColmapDatabase(path, Small());
  const ColmapDatabase database(path);
  REQUIRE(database.images().size() == 2);
  CHECK(database.images().at(2).name == "sub/it's.jpg");
  CHECK(database.CameraOf(1).parameters == std::vector<double>{500, 320, 240, 0.1});
  CHECK(database.CameraOf(1).has_prior_focal_length);
  CHECK_FALSE(database.CameraOf(2).has_prior_focal_length);
  CHECK(database.CameraOf(2).size == ImageSize{200, 180});
  CHECK(database.Keypoints(1) == Small().images[0].keypoints);
  CHECK((database.KeypointFrames(1) - Small().images[0].frames).cwiseAbs().maxCoeff() < 1e-6);
  CHECK(database.Matches({1, 2}) == Crossed(3));
}

TEST_CASE("a COLMAP database that cannot be written is an error, and leaves what was there") {
  TemporaryFolder folder;
  CHECK(Has(ErrorOf([&] { CreateColmapDatabase(folder / "no/new.db", Small()); }), "no/new.db"));
  const std::string path = folder / "new.db";
  CreateColmapDatabase(path, Small());
  NewColmapDatabase twice = Small();
  twice.images[1].name = twice.images[0].name;
  CHECK(Has(ErrorOf([&] { CreateColmapDatabase(path, twice); }), "new.db"));
  CHECK(ColmapDatabase(path).images().at(2).name == "sub/it's.jpg");
}

}  // namespace

}  // namespace diffsac
