// COLMAP models, made here.
#include "lab/colmap/model.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <filesystem>
#include <limits>

#include "core/errors.h"
#include "lab/images/image_source.h"
#include "lab/images/image_test_util.h"
#include "lab/images/run_pairs.h"

namespace diffsac {
namespace {

template <class T>
std::string Bytes(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

std::string Camera(int id, int model, const std::vector<double>& parameters) {
  std::string bytes =
      Bytes<std::int32_t>(id) + Bytes<std::int32_t>(model) + Bytes<std::uint64_t>(10) + Bytes<std::uint64_t>(8);
  for (double value : parameters) bytes += Bytes(value);
  return bytes;
}

/// At (1, 2, 3), with one point.
std::string Image(const std::string& name, int camera, const std::vector<double>& quaternion) {
  std::string bytes = Bytes<std::int32_t>(7);
  for (double value : quaternion) bytes += Bytes(value);
  for (double value : {1.0, 2.0, 3.0}) bytes += Bytes(value);
  bytes += Bytes<std::int32_t>(camera) + name + '\0' + Bytes<std::uint64_t>(1);
  return bytes + Bytes(4.0) + Bytes(5.0) + Bytes<std::int64_t>(-1);
}

struct BinaryModel {
  TemporaryFolder folder;
  std::string root = folder / "door";
  BinaryModel() { MakeFolder(root + "/sparse/0"); }
  void Write(const std::string& cameras, const std::string& images) {
    WriteRaw(root + "/sparse/0/cameras.bin", cameras);
    WriteRaw(root + "/sparse/0/images.bin", images);
  }
};

const std::string kCameras =
    Bytes<std::uint64_t>(2) + Camera(1, 2, {500, 5, 4, -0.03}) + Camera(2, 1, {500, 510, 5, 4});

constexpr double kInfinity = std::numeric_limits<double>::infinity(), kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("COLMAP's binary models: what the same text model says") {
  BinaryModel model;
  model.Write(kCameras,
              Bytes<std::uint64_t>(2) + Image("b 1.jpg", 1, {0.6, 0, 0, 0.8}) + Image("a-1.jpg", 2, {1, 0, 0, 0}));
  const ImageSource source = ReadColmap(model.root);
  REQUIRE(source.images.size() == 2);
  CHECK(source.scenes[0].pairs.size() == 1);
  CHECK(source.images[0].name == "a_1");
  CHECK(source.images[0].path == model.root + "/images/a-1.jpg");
  CHECK(source.images[0].camera->K == Calibration(500, 510, 4.5, 3.5));
  const SourceImage& turned = source.images[1];
  CHECK(turned.name == "b 1");
  CHECK(turned.camera->colmap.value().parameters.back() == -0.03);
  CHECK(turned.camera->size == ImageSize{10, 8});
  CHECK(turned.pose->rotation(1, 0) == Approx(0.96));
  CHECK(turned.pose->translation == Eigen::Vector3d(1, 2, 3));

  // A text model beside it goes first.
  WriteRaw(model.root + "/cameras.txt", "1 PINHOLE 10 8 600 600 5 4\n");
  WriteRaw(model.root + "/images.txt", "1 1 0 0 0 1 2 3 1 c.jpg\n\n2 1 0 0 0 1 2 4 1 d.jpg\n\n");
  CHECK(ReadColmap(model.root).images[0].name == "c");
}

TEST_CASE("COLMAP's models: lenses of every kind bend as COLMAP says, and a fisheye sees what no pinhole camera does") {
  BinaryModel model;
  const std::vector<double> fisheye = {300, 300, 500, 400, 0.02, -0.01, 0.0, 0.0};
  model.Write(Bytes<std::uint64_t>(2) + Camera(1, 5, fisheye) + Camera(2, 9, {300, 500, 400, 0.02, -0.01}),
              Bytes<std::uint64_t>(2) + Image("a.jpg", 1, {1, 0, 0, 0}) + Image("b.jpg", 2, {1, 0, 0, 0}));
  for (const SourceImage& image : ReadColmap(model.root).images) {
    const LensCamera& camera = image.camera.value();
    CHECK_FALSE(camera.IsStraight());
    CHECK(camera.K == Calibration(300, 300, 499.5, 399.5));
    const Eigen::Vector2d pixel(700.0, 250.0), straight = camera.Undistort(pixel);
    CHECK((straight - pixel).norm() > 10.0);
    CHECK((camera.Distort(straight) - pixel).norm() < 1e-6);
    CHECK(std::isnan(camera.Undistort({499.5 + 300.0 * 1.8, 399.5}).x()));
    CHECK(camera.colmap->parameters[0] == 300.0);
  }
}

TEST_CASE(
    "COLMAP's models: names have blanks, a byte order mark is passed over, a bad image or camera costs no other") {
  BinaryModel model;
  WriteRaw(model.root + "/cameras.txt",
           "\xEF\xBB\xBF# cameras\n1 PINHOLE 10 8 600 600 5 4\n2 PINHOLE 10 8 nan 600 5 4\none PINHOLE 1\n");
  WriteRaw(model.root + "/images.txt",
           "1 1 0 0 0 1 2 3 1 IMG 1 (2).png\r\n1 2 -1\r\n2 1 0 0 0 1 2 4 1 d.jpg\n\n3 nan 0 0 0 1 2 4 1 e.jpg\n\n"
           "4 1 0 0 0 1 2 4 2 f.jpg\n\n5 1 0 0\n\n");
  const ImageSource source = ReadColmap(model.root);
  REQUIRE(source.images.size() == 2);
  CHECK(source.images[0].path == model.root + "/images/IMG 1 (2).png");
  REQUIRE(source.left_out.size() == 3);
  CHECK(Has(source.left_out[0].problem, "images.txt:5: e.jpg: expected a pose"));
  CHECK(Has(source.left_out[1].problem, "cameras.txt:3: expected finite parameters"));
  CHECK(Has(source.left_out[2].problem, "images.txt:9: expected IMAGE_ID"));
}

TEST_CASE("COLMAP's binary models: mistakes name the file") {
  BinaryModel model;
  const auto error = [&](const std::string& cameras, const std::string& images) {
    model.Write(cameras, images);
    return ErrorOf([&] { ReadColmap(model.root); });
  };
  const std::string images = Bytes<std::uint64_t>(1) + Image("a.jpg", 1, {1, 0, 0, 0});
  CHECK(Has(error(kCameras.substr(0, 40), images), "cameras.bin: ends early"));
  CHECK(Has(error(kCameras, images.substr(0, images.size() - 1)), "images.bin: ends early"));
  CHECK(Has(error(kCameras, images.substr(0, 70)), "images.bin: ends early"));
  CHECK(Has(error(Bytes<std::uint64_t>(1) + Camera(1, 77, {}), images), "77 is not supported"));
  CHECK(Has(error(kCameras, Bytes<std::uint64_t>(1) + Image("a.jpg", 3, {1, 0, 0, 0})),
            "a.jpg: cameras.bin has no camera 3"));
  CHECK(Has(error(kCameras, Bytes<std::uint64_t>(1) + Image("a.jpg", 1, {0, 0, 0, 0})), "with a rotation"));
  for (const double value : {kInfinity, kNaN, 0.0, -500.0})
    CHECK(Has(error(Bytes<std::uint64_t>(1) + Camera(1, 2, {value, 5, 4, 0}), images),
              "cameras.bin: expected finite parameters"));
  // An infinite quaternion was a pose without numbers.
  for (const double value : {kInfinity, -kInfinity, kNaN, 1e200})
    CHECK(Has(error(kCameras, Bytes<std::uint64_t>(1) + Image("a.jpg", 1, {1, value, 0, 0})),
              "expected a pose of finite"));
}

}  // namespace diffsac
