#include "lab/images/image_source.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/errors.h"
#include "lab/files/text_scan.h"
#include "lab/images/image_test_util.h"

namespace diffsac {
namespace {

std::string KittiFolder(const TemporaryFolder& folder) {
  const std::string root = folder / "kitti";
  MakeFolder(root + "/sequences/03/image_0");
  MakeFolder(root + "/poses");
  for (const char* name : {"000000", "000001", "000003"}) WriteSmall(root + "/sequences/03/image_0/" + name + ".png");
  WriteRaw(root + "/sequences/03/calib.txt", "P0: 700 0 600 0 0 701 180 0 0 0 1 0\nP1: 1 2 3\n");
  std::string poses;
  for (int i = 0; i < 4; ++i) poses += "0 -1 0 " + std::to_string(i) + " 1 0 0 2 0 0 1 3\n";
  WriteRaw(root + "/poses/03.txt", poses);
  return root;
}

}  // namespace

TEST_CASE("distortion and its removal are inverse") {
  LensCamera camera;
  Rng rng(1);
  for (int round = 0; round < 3; ++round) {
    ColmapCamera colmap{4, {640, 480}, {800, 810, 320.5, 240.5, 0, 0, 0, 0}};
    if (round > 0) colmap.parameters[4] = -0.1, colmap.parameters[5] = 0.02;
    if (round > 1) colmap.parameters[6] = 1e-3, colmap.parameters[7] = -2e-3;
    camera = CameraOfColmap(colmap, "here");
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector2d pixel(rng.Uniform(0, 640), rng.Uniform(0, 480));
      CHECK((camera.Distort(camera.Undistort(pixel)) - pixel).norm() < 1e-8);
      if (round == 0) CHECK(camera.Undistort(pixel) == pixel);
    }
  }
  // Barrel distortion draws to the centre, so taking it out moves outwards.
  CHECK(camera.Undistort({0, 240}).x() < 0.0);
}

TEST_CASE("numbers in text files") {
  TemporaryFolder folder;
  const std::string path = folder / "n.txt";
  WriteRaw(path, "# a comment\n1 2\r\n\n 3\t-4e1\n");
  const auto lines = ReadNumberFile(path, 2);
  REQUIRE(lines.size() == 2);
  CHECK(lines[1].line == 4);
  CHECK(lines[1].values == std::vector<double>{3, -40});
  CHECK(Has(ErrorOf([&] { ReadNumberFile(path, 3); }), "n.txt:2: expected 3 numbers"));
  WriteRaw(path, "1 2\n3 x\n");
  CHECK(Has(ErrorOf([&] { ReadNumberFile(path); }), "n.txt:2: 'x'"));
  WriteRaw(path, "1 2 3 4 5 6\n7 8 9\n");
  CHECK(ReadMatrixFile(path)(1, 2) == 6);
  WriteRaw(path, "1 2 3 4\n");
  CHECK(Has(ErrorOf([&] { ReadMatrixFile(path); }), "3x3"));
}

TEST_CASE("KITTI: camera-to-world poses, pairs by step, frames that are missing") {
  TemporaryFolder folder;
  const std::string root = KittiFolder(folder);
  const ImageSource source = ReadKitti(root, "03", {1, {1, 2, 3}});
  REQUIRE(source.images.size() == 3);
  CHECK(source.images[2].name == "000003");
  CHECK(source.images[0].camera->K == Calibration(700, 701, 600, 180));
  // The centre of camera 3 is (3, 2, 3).
  const RigidMotion pose = *source.images[2].pose;
  CHECK((pose.rotation * Eigen::Vector3d(3, 2, 3) + pose.translation).norm() < 1e-12);
  CHECK(pose.rotation(0, 1) == 1.0);
  REQUIRE(source.scenes.size() == 3);
  CHECK(source.scenes[0].name == "kitti_03_step_01");
  CHECK(source.scenes[0].pairs.size() == 1);
  REQUIRE(source.scenes[1].pairs.size() == 1);
  CHECK((source.scenes[1].pairs[0].image1 == 1 && source.scenes[1].pairs[0].image2 == 2));

  const auto error = [&](const std::vector<int>& steps = {1}) {
    return ErrorOf([&] { ReadKitti(root, "03", {1, steps}); });
  };
  CHECK(Has(error({7}), "kitti_03_step_07"));
  CHECK(Has(error({0}), "positive"));
  CHECK(Has(ErrorOf([&] { ReadKitti(root, "99"); }), "99"));
  WriteSmall(root + "/sequences/03/image_0/000009.png");
  // A frame without a pose, or with one that makes no sense, is left out.
  const ImageSource more = ReadKitti(root, "03");
  CHECK(more.images.size() == 3);
  REQUIRE(more.left_out.size() == 1);
  CHECK(Has(more.left_out[0].problem, "no pose for"));
  std::filesystem::remove(root + "/sequences/03/image_0/000009.png");
  const std::string good = "0 -1 0 0 1 0 0 2 0 0 1 3\n", broken = "nan -1 0 0 1 0 0 2 0 0 1 3\n";
  WriteRaw(root + "/poses/03.txt", broken + good + good + good);
  const ImageSource fewer = ReadKitti(root, "03", {1, {2}});
  CHECK(fewer.images.size() == 2);
  REQUIRE(fewer.left_out.size() == 1);
  CHECK(fewer.left_out[0].name == "000000");
  CHECK(Has(fewer.left_out[0].problem, "03.txt:1: the pose is not finite"));
  WriteRaw(root + "/poses/03.txt", good + "0 -2 0 0 1 0 0 2 0 0 1 3\n" + good + good);
  CHECK(Has(error({2}), "03.txt:2: the pose holds no rotation"));
  WriteRaw(root + "/poses/03.txt", "1 2 3\n");
  CHECK(Has(error(), "03.txt:1: expected 12 numbers"));
  WriteRaw(root + "/sequences/03/calib.txt", "P0: 700 0\n");
  CHECK(Has(error(), "calib.txt:1"));
  WriteRaw(root + "/sequences/03/calib.txt", "P2: 700 0\n");
  CHECK(Has(error(), "no line P0"));
}

TEST_CASE("COLMAP: world-to-camera quaternions, its pixels, lines without points") {
  TemporaryFolder folder;
  const std::string root = folder / "door";
  MakeFolder(root + "/images");
  MakeFolder(root + "/sparse/0");
  const auto write = [&](const std::string& cameras, const std::string& images) {
    WriteRaw(root + "/sparse/0/cameras.txt", cameras);
    WriteRaw(root + "/sparse/0/images.txt", images);
  };
  const std::string cameras =
      "# comment\n1 SIMPLE_RADIAL 10 8 500 5 4 -0.03\n2 OPENCV 10 8 500 510 5 4 0.1 0.2 0.3 0.4\n3 PINHOLE 10 8 1 2 3 "
      "4\n";
  const std::string images = "# comment\n2 0.6 0 0 0.8 1 2 3 1 b.jpg\n1 2 -1\n1 1 0 0 0 1 2 3 2 a-1.jpg\n\n";
  write(cameras, images);
  const ImageSource source = ReadColmap(root);
  REQUIRE(source.images.size() == 2);
  CHECK(source.images[0].name == "a_1");
  CHECK(source.images[0].path == root + "/images/a-1.jpg");
  CHECK(source.images[0].pose->rotation == Eigen::Matrix3d::Identity());
  CHECK(source.images[0].camera->colmap->parameters.back() == 0.4);
  CHECK(source.images[0].camera->K == Calibration(500, 510, 4.5, 3.5));
  const LensCamera& camera = *source.images[1].camera;
  CHECK(camera.K == Calibration(500, 500, 4.5, 3.5));
  CHECK(camera.colmap->parameters.back() == -0.03);
  CHECK(camera.size == ImageSize{10, 8});
  // A turn about z by 2 acos 0.6, sin = 0.96.
  CHECK(source.images[1].pose->rotation(1, 0) == Approx(0.96));
  CHECK(source.images[1].pose->translation == Eigen::Vector3d(1, 2, 3));
  CHECK(source.scenes[0].pairs.size() == 1);

  const auto error = [&] { return ErrorOf([&] { ReadColmap(root); }); };
  write("1 FISHEYE 10 8 1 2 3\n", images);
  CHECK(Has(error(), "cameras.txt:1: the camera model FISHEYE"));
  write("1 PINHOLE 10 8 1 2 3\n", images);
  CHECK(Has(error(), "cameras.txt:1: expected 4 parameters"));
  write(cameras, "1 0.6 0 0 0.8 1 2 3 7 b.jpg\n\n");
  CHECK(Has(error(), "images.txt:1: cameras.txt has no camera 7"));
  write(cameras, "1 0.6 0 0\n\n");
  CHECK(Has(error(), "images.txt:1: expected IMAGE_ID"));
  write(cameras, "1 0 0 0 0 1 2 3 1 b.jpg\n\n");
  CHECK(Has(error(), "rotation"));
  write(cameras, "1 1 0 0 zero 1 2 3 1 b.jpg\n\n");
  CHECK(Has(error(), "'zero'"));
  CHECK(Has(ErrorOf([&] { ReadColmap(folder.path()); }), "no COLMAP text model"));
}

TEST_CASE("homographies under both names, and folders of images") {
  TemporaryFolder folder;
  const std::string graf = folder / "graf", hpatches = folder / "v_dog";
  MakeFolder(graf);
  MakeFolder(hpatches);
  for (int n = 1; n <= 3; ++n) {
    WriteSmall(graf + "/img" + std::to_string(n) + ".png");
    WriteSmall(hpatches + "/" + std::to_string(n) + ".ppm");
  }
  for (const std::string& path : {graf + "/H1to2p", graf + "/H1to3p", hpatches + "/H_1_2", hpatches + "/H_1_3"})
    WriteRaw(path, "1 2 3\n4 5 6\n7 8 9\n");
  const ImageSource oxford = ReadHomographies(graf), patches = ReadHomographies(hpatches);
  CHECK(oxford.images[2].name == "img3");
  CHECK(patches.images[2].name == "3");
  CHECK(patches.scenes[0].name == "v_dog");
  for (const ImageSource& source : {oxford, patches}) {
    REQUIRE(source.scenes[0].pairs.size() == 2);
    const SourcePair& pair = source.scenes[0].pairs[1];
    CHECK((pair.image1 == 0 && pair.image2 == 2));
    CHECK((*pair.homography)(0, 1) == 2);
    CHECK(!source.images[0].pose);
  }
  std::filesystem::remove(graf + "/img2.png");
  // The others stay.
  const ImageSource rest = ReadHomographies(graf);
  CHECK(Has(rest.left_out.at(0).problem, "no image img2"));
  REQUIRE(rest.scenes[0].pairs.size() == 1);
  CHECK(rest.images[rest.scenes[0].pairs[0].image2].name == "img3");
  WriteRaw(hpatches + "/H_1_3", "1 2\n");
  CHECK(Has(ReadHomographies(hpatches).left_out.at(0).problem, "H_1_3"));

  WriteRaw(folder / "K.txt", "500 0 5\n0 500 4\n0 0 1\n");
  CHECK(ReadImageFolder(hpatches).scenes[0].pairs.size() == 3);
  CHECK(!ReadImageFolder(hpatches).images[0].camera);
  CHECK(ReadImageFolder(hpatches, {folder / "K.txt", 0.0, {}}).images[0].camera->K == Calibration(500, 500, 5, 4));
  WriteRaw(folder / "K.txt", "500 0 5\n0 0 4\n0 0 1\n");
  CHECK(Has(ErrorOf([&] { ReadImageFolder(hpatches, {folder / "K.txt", 0.0, {}}); }), "calibration"));
  CHECK(Has(ErrorOf([&] { ReadHomographies(folder.path()); }), "no images"));
  WriteSmall(hpatches + "/1.png");
  CHECK(Has(ErrorOf([&] { ReadImageFolder(hpatches); }), "two images are named 1"));
  TemporaryFolder single;
  WriteSmall(single / "a.png");
  CHECK(Has(ErrorOf([&] { ReadImageFolder(single.path()); }), "no pairs"));
  CHECK(Has(ErrorOf([&] { ReadHomographies(single.path()); }), "no homographies"));
}

}  // namespace diffsac
