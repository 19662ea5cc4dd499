#include "lab/images/image_cameras.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/errors.h"
#include "core/temporary_folder.h"
#include "guidance/captured_log.h"
#include "lab/images/exif_focal.h"
#include "lab/images/exif_test_util.h"

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

TEST_CASE("calibrations of other units or sizes are told") {
  TemporaryFolder folder;
  const auto said = [&](const GivenCalibration& given, const ImageSize& size) {
    std::string error;
    const std::string log = CapturedLog([&] { error = ErrorOf([&] { ImageCameras(given, kPaths).Of(0, size); }); });
    return error + log;
  };
  GivenCalibration given;
  for (const double focal : {35.0, 1.2, 60.0}) {
    given.focal = focal;
    CHECK(Has(said(given, kWide), "--focal: a focal length of "));
  }
  for (const double focal : {100.0, 500.0, 9000.0}) {
    given.focal = focal;
    CHECK(said(given, kHigh).empty());
  }
  given = {WriteK(&folder, "k.txt", 500.0), 0.0, {}};
  for (const ImageSize& size : {kWide, ImageSize{700, 440}, ImageSize{}}) CHECK(said(given, size).empty());
  CHECK(
      Has(said(given, {320, 240}), "k.txt: the principal point (320, 240) is far from the middle of 320x240: unless"));
  CHECK(Has(said(given, {1600, 1200}), "of another size, 641x481, say"));
  CHECK(Has(said(given, {1600, 480}), "is far from the middle"));
  given = {WriteK(&folder, "small.txt", 5.0), 0.0, {}};
  CHECK(Has(said(given, kWide), "small.txt: a focal length of 5 pixels would see 178 degrees of 640x480"));
}

TEST_CASE("one focal length for images of two sizes is told") {
  const ImageCameras cameras({"", 600.0, {}}, kPaths);
  const auto said = [&](const ImageSize& second) { return CapturedLog([&] { cameras.WarnOfSizes({kWide, second}); }); };
  CHECK(said(kWide).empty());
  CHECK(said(kHigh).empty());
  CHECK(Has(said({320, 240}), "one --focal, in pixels, for images of 640x480 and 320x240"));
}

TEST_CASE("a matrix with commas, as JSON or as NumPy's") {
  TemporaryFolder folder;
  const auto read = [&](const std::string& name, const std::string& text) {
    WriteRaw(folder / name, text);
    return ReadCalibrationMatrix(folder / name);
  };
  const Eigen::Matrix3d K = (Eigen::Matrix3d() << 500, 0, 320, 0, 510, 240, 0, 0, 1).finished();
  for (const char* text :
       {"500, 0, 320\n0,510,240\n0,0,1\n", "500;0;320;0;510;240;0;0;1", "[[500, 0, 320], [0, 510, 240], [0, 0, 1]]",
        "[[500. 0. 320.]\n [0. 510. 240.]\n [0. 0. 1.]]\n", "{\"K\": [[500, 0, 320], [0, 510, 240], [0, 0, 1]]}",
        "{\"camera_matrix\": {\"rows\": 3, \"data\": [500, 0, 320, 0, 510, 240, 0, 0, 1]}}",
        "\n{\"fx\": 500, \"fy\": 510, \"cx\": 320, \"cy\": 240}"}) {
    CAPTURE(text);
    CHECK(read("k.json", text) == K);
  }
  for (const char* text :
       {"{\"K\": [500, 0, 320]}", "{\"K1\": 3}", "{\"fx\": \"a\", \"fy\": 1, \"cx\": 1, \"cy\": 1}"}) {
    CAPTURE(text);
    CHECK(Has(ErrorOf([&] { read("k.json", text); }), "k.json: expected a 3x3 matrix at K or camera_matrix"));
  }
  CHECK(Has(ErrorOf([&] { read("k.json", "{\"K\": "); }), "k.json: no JSON"));
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
    CHECK(cameras.Of(0, kWide)->colmap->parameters.back() == -0.1);
    CHECK(cameras.Of(1, kHigh)->K(0, 0) == 600.0);
    CHECK(Has(ErrorOf([&] { cameras.Of(1, kWide); }), "photos/b.jpg: is 640x480, but its camera is for 480x640"));
  }
  WriteRaw(folder / "cameras.txt", "1 simple_radial 640 480 500 320 240 -0.1\n7 PINHOLE 480 640 600 600 240 320\n");
  CHECK(Has(ErrorOf([&] { ImageCameras(given, kPaths).Of(0, kWide); }),
            "photos/a.jpg: " + folder / "cameras.txt" +
                ":1: the camera model simple_radial is not supported: SIMPLE_RADIAL"));
  WriteRaw(folder / "cameras.txt", "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1\n7 pinhole 480 640 600 600 240 320\n");
  WriteRaw(folder / "images.txt", "1 1 0 0 0 0 0 0 7 photos/b.jpg\n\n");
  CHECK(Has(ErrorOf([&] { ImageCameras(given, kPaths); }), "pinhole is not supported: PINHOLE is the nearest"));
  const std::string good = "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1\n7 PINHOLE 480 640 600 600 240 320\n";
  WriteRaw(folder / "cameras.txt", good);
  WriteRaw(folder / "images.txt", "1 1 0 0 0 0 0 0 7 photos/b.jpg\n\n2 1 0 0 0 0 0 0 1 a.jpg\n\n");
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

constexpr std::uint16_t kFilm = 0xA405, kFocal = 0x920A, kXResolution = 0xA20E, kResolutionUnit = 0xA210,
                        kWidth = 0xA002, kHeight = 0xA003, kMake = 0x010F, kModel = 0x0110;
const ImageSize kSize{40, 30};

std::string Jpeg() {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", cv::Mat(30, 40, CV_8U, cv::Scalar(90)), bytes);
  return {bytes.begin(), bytes.end()};
}

std::optional<double> FocalOf(const ExifBytes& exif, const ImageSize& size = kSize) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("a.jpg"), WithExif(Jpeg(), exif.ToString()));
  return ExifFocalPx(folder.File("a.jpg"), size);
}

/// A camera of 4000 × 3000 pixels of 2 µm with a lens of 5 mm, 2500 pixels.
ExifBytes ByPlane() {
  ExifBytes exif;
  exif.shorts = {{kWidth, 4000}, {kHeight, 3000}, {kResolutionUnit, 3}};
  exif.rationals = {{kFocal, {50, 10}}, {kXResolution, {5000, 1}}};
  return exif;
}

TEST_CASE("EXIF's focal length on film is by the diagonal, either way up, in both byte orders") {
  for (const bool big_endian : {false, true}) {
    const ExifBytes exif{{{kFilm, 28}}, {}, big_endian};
    const auto focal = FocalOf(exif);
    REQUIRE(focal);
    CHECK(*focal == Approx(28.0 * 50.0 / std::hypot(36.0, 24.0)));
    CHECK(FocalOf(exif, {30, 40}) == focal);
  }
}

TEST_CASE("EXIF's focal length by the sensor's resolution, in every unit, of reduced and turned images") {
  ExifBytes exif = ByPlane();
  CHECK(FocalOf(exif, {4000, 3000}).value() == Approx(2500.0));
  CHECK(FocalOf(exif).value() == Approx(25.0));
  CHECK(FocalOf(exif, {30, 40}).value() == Approx(25.0));
  exif.shorts[kResolutionUnit] = 2;
  exif.rationals[kXResolution] = {12700, 1};
  CHECK(FocalOf(exif).value() == Approx(25.0));
  exif.shorts.erase(kResolutionUnit);
  CHECK(FocalOf(exif).value() == Approx(25.0));
  exif.shorts[kResolutionUnit] = 4;
  exif.rationals[kXResolution] = {500, 1};
  CHECK(FocalOf(exif).value() == Approx(25.0));
  exif.shorts[kFilm] = 30;
  CHECK(FocalOf(exif).value() == Approx(30.0 * 50.0 / std::hypot(36.0, 24.0)));
}

TEST_CASE("EXIF's focal length by the sensor that the camera's name says, where nothing on film is said") {
  ExifBytes exif;
  exif.rationals = {{kFocal, {50, 1}}};
  exif.texts = {{kMake, "NIKON CORPORATION"}, {kModel, "NIKON D90"}};
  if (!CropFactor("NIKON CORPORATION", "NIKON D90")) {  // A build without lensfun.
    CHECK_FALSE(FocalOf(exif));
    return;
  }
  // 23.6 mm wide.
  CHECK(FocalOf(exif).value() == Approx(50.0 / 23.6 * 40.0).epsilon(0.03));
  CHECK(FocalOf(exif, {30, 40}) == FocalOf(exif));
  exif.texts[kModel] = "NIKON D90  ";
  CHECK(FocalOf(exif));
  exif.shorts[kFilm] = 30;
  CHECK(FocalOf(exif).value() == Approx(30.0 * 50.0 / std::hypot(36.0, 24.0)));
  exif.shorts.clear();
  exif.texts[kModel] = "no such camera";
  CHECK_FALSE(FocalOf(exif));
  exif.texts.erase(kMake);
  CHECK_FALSE(FocalOf(exif));
}

TEST_CASE("zeros, a cropped image and impossible lenses are no focal length") {
  CHECK_FALSE(FocalOf({{{kFilm, 0}}}));
  CHECK_FALSE(FocalOf({}));
  CHECK_FALSE(FocalOf({{{kFilm, 1}}}));
  CHECK_FALSE(FocalOf({{{kFilm, 65000}}}));
  CHECK_FALSE(FocalOf({{{kFilm, 28}, {kWidth, 4000}, {kHeight, 2000}}}));
  CHECK_FALSE(FocalOf({{{kFilm, 28}}}, {}));
  for (const std::uint16_t tag : {kFocal, kXResolution}) {
    ExifBytes exif = ByPlane();
    exif.rationals[tag] = {0, 1};
    CHECK_FALSE(FocalOf(exif));
    exif.rationals[tag] = {5, 0};
    CHECK_FALSE(FocalOf(exif));
    exif.rationals.erase(tag);
    CHECK_FALSE(FocalOf(exif));
  }
}

TEST_CASE("a file without EXIF data, with damaged ones or none at all has no focal length") {
  const TemporaryFolder folder;
  const std::string path = folder.File("a.jpg"), exif = ByPlane().ToString();
  CHECK_FALSE(ExifFocalPx(path, kSize));
  for (const std::string& bytes : {std::string(), std::string("no image"), Jpeg(), WithExif(Jpeg(), "")}) {
    WriteFileAtomically(path, bytes);
    CHECK_FALSE(ExifFocalPx(path, kSize));
  }
  for (std::size_t size = 0; size < exif.size(); ++size) {
    WriteFileAtomically(path, WithExif(Jpeg(), exif.substr(0, size)));
    const auto focal = ExifFocalPx(path, kSize);
    if (focal) CHECK(*focal == Approx(25.0));
  }
  for (std::size_t place = 0; place < exif.size(); ++place) {
    std::string damaged = exif;
    damaged[place] = static_cast<char>(~damaged[place]);
    WriteFileAtomically(path, WithExif(Jpeg(), damaged));
    const auto focal = ExifFocalPx(path, kSize);
    if (focal) CHECK(std::isfinite(*focal));
  }
}

}  // namespace

}  // namespace diffsac
