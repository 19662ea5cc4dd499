#include "lab/images/image_cameras.h"

#include <catch2/catch.hpp>

#include "core/errors.h"
#include "core/temporary_folder.h"

namespace diffsac {
namespace {

const std::vector<std::string> kPaths = {"photos/a.jpg", "photos/b.jpg"};
constexpr ImageSize kWide{640, 480}, kHigh{480, 640};

std::string WriteK(TemporaryFolder* folder, const std::string& name, double focal) {
  const std::string path = folder->File(name), f = std::to_string(focal);
  WriteRaw(path, f + " 0 320\n0 " + f + " 240\n0 0 1\n");
  return path;
}

TEST_CASE("one K for all images, or one for each") {
  TemporaryFolder folder;
  const std::string first = WriteK(&folder, "a.txt", 500.0), second = WriteK(&folder, "b.txt", 700.0);
  const ImageCameras shared({first, 0.0, {}}, kPaths);
  CHECK(shared.given());
  CHECK(shared.Of(1, kWide)->K(0, 0) == 500.0);
  GivenCalibration each;
  each.files = {first, second};
  const ImageCameras apart(each, kPaths);
  CHECK(apart.Of(0, kWide)->K(0, 0) == 500.0);
  CHECK(apart.Of(1, kWide)->K(0, 0) == 700.0);
  each.files.push_back(first);
  CHECK(Has(ErrorOf([&] { ImageCameras(each, kPaths); }), "one for each of the 2 images, found 3"));
  each.focal = 300.0;
  CHECK(Has(ErrorOf([&] { ImageCameras(each, kPaths); }), "--calibration excludes --focal"));
  each = {};
  each.files = {first, folder / "none.txt"};
  CHECK(Has(ErrorOf([&] { ImageCameras(each, kPaths); }), "none.txt"));
}

TEST_CASE("a focal length without a centre takes the middle of each image, turned ones too") {
  const ImageCameras cameras({"", 600.0, {}}, kPaths);
  CHECK(cameras.Of(0, kWide)->K(0, 2) == 319.5);
  CHECK(cameras.Of(1, kHigh)->K(0, 2) == 239.5);
  CHECK(cameras.Of(1, kHigh)->K(1, 2) == 319.5);
  CHECK(ImageCameras({"", 600.0, {10.0, 20.0}}, kPaths).Of(1, kHigh)->K(1, 2) == 20.0);
  CHECK(Has(ErrorOf([] { ImageCameras({"", -1.0, {}}, kPaths); }), "positive --focal"));
  const ImageCameras none({}, kPaths);
  CHECK_FALSE(none.given());
  CHECK_FALSE(none.Of(0, kWide));
}

TEST_CASE("COLMAP's cameras go to the images of their names, one alone to all") {
  TemporaryFolder folder;
  GivenCalibration given;
  given.cameras = folder.path();
  WriteRaw(folder / "cameras.txt", "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1\n7 PINHOLE 480 640 600 600 240 320\n");
  WriteRaw(folder / "images.txt", "1 1 0 0 0 0 0 0 7 photos/b.jpg\n\n2 1 0 0 0 0 0 0 1 a.jpg\n\n");
  for (const std::string& name : {std::string(folder.path()), folder / "cameras.txt"}) {
    given.cameras = name;
    const ImageCameras cameras(given, kPaths);
    CHECK(cameras.Of(0, kWide)->k1 == -0.1);
    CHECK(cameras.Of(1, kHigh)->K(0, 0) == 600.0);
    CHECK(Has(ErrorOf([&] { cameras.Of(1, kWide); }), "photos/b.jpg: is 640x480, but its camera is for 480x640"));
  }
  const ImageCameras other(given, {"photos/c.jpg", "b.jpg"});
  CHECK(Has(ErrorOf([&] { other.Of(0, kWide); }), "photos/c.jpg: "));
  // Another folder's image of the same name is another one.
  CHECK(Has(ErrorOf([&] { other.Of(1, kHigh); }), "has no such image"));

  std::filesystem::remove(folder / "images.txt");
  CHECK(Has(ErrorOf([&] { ImageCameras(given, kPaths); }), "cameras.txt: expected one camera, or images.txt"));
  WriteRaw(folder / "cameras.txt", "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1\n");
  CHECK(ImageCameras(given, kPaths).Of(1, kWide)->K(0, 2) == 319.5);
  given.focal = 300.0;
  CHECK(Has(ErrorOf([&] { ImageCameras(given, kPaths); }), "--cameras excludes"));
}

}  // namespace
}  // namespace diffsac
