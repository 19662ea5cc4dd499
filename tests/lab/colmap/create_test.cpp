#include "lab/colmap/create.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/errors.h"
#include "lab/colmap/colmap_test_util.h"

namespace diffsac {
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
