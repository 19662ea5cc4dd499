#include "lab/images/image_source.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/errors.h"
#include "lab/images/image_test_util.h"
#include "lab/images/number_file.h"

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
  camera.K = Calibration(800, 810, 320, 240);
  Rng rng(1);
  for (int round = 0; round < 3; ++round) {
    if (round > 0) camera.k1 = -0.1, camera.k2 = 0.02;
    if (round > 1) camera.p1 = 1e-3, camera.p2 = -2e-3;
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
  const ImageSource source = ReadKitti(root, "03", {1, 2, 3});
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
    return ErrorOf([&] { ReadKitti(root, "03", steps); });
  };
  CHECK(Has(error({7}), "kitti_03_step_07"));
  CHECK(Has(error({0}), "positive"));
  CHECK(Has(error({}), "at least one"));
  CHECK(Has(ErrorOf([&] { ReadKitti(root, "99", {1}); }), "99"));
  WriteSmall(root + "/sequences/03/image_0/000009.png");
  // A frame without a pose, or with one that makes no sense, is left out.
  const ImageSource more = ReadKitti(root, "03", {1});
  CHECK(more.images.size() == 3);
  REQUIRE(more.left_out.size() == 1);
  CHECK(Has(more.left_out[0].problem, "no pose for"));
  std::filesystem::remove(root + "/sequences/03/image_0/000009.png");
  const std::string good = "0 -1 0 0 1 0 0 2 0 0 1 3\n", broken = "nan -1 0 0 1 0 0 2 0 0 1 3\n";
  WriteRaw(root + "/poses/03.txt", broken + good + good + good);
  const ImageSource fewer = ReadKitti(root, "03", {2});
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

TEST_CASE("Strecha: camera-to-world rotation and centre") {
  TemporaryFolder folder;
  const std::string root = folder / "castle-P2";
  MakeFolder(root + "/images");
  MakeFolder(root + "/gt_dense_cameras");
  const std::string good = "500 0 160 \n0 505 120 \n0 0 1 \n0 0 0\n0 -1 0\n1 0 0\n0 0 1\n4 5 6\n10 8\n";
  for (const char* name : {"0000", "0001", "0002"}) {
    WriteSmall(root + "/images/" + name + ".jpg");
    WriteRaw(root + "/gt_dense_cameras/" + name + ".jpg.camera", good);
  }
  const ImageSource source = ReadStrecha(root);
  REQUIRE(source.scenes.size() == 1);
  CHECK(source.scenes[0].name == "castle-P2");
  CHECK(source.scenes[0].pairs.size() == 3);
  const RigidMotion pose = *source.images[1].pose;
  CHECK((pose.rotation * Eigen::Vector3d(4, 5, 6) + pose.translation).norm() < 1e-12);
  CHECK(pose.rotation(0, 1) == 1.0);
  CHECK(source.images[1].camera->K == Calibration(500, 505, 160, 120));
  CHECK(source.images[1].camera->size == ImageSize{10, 8});

  const std::string path = root + "/gt_dense_cameras/0001.jpg.camera";
  // The first problem of the images that are left out; two of three stay.
  const auto error = [&](const std::string& text) {
    WriteRaw(path, text);
    const ImageSource source = ReadStrecha(root);
    CHECK(source.images.size() == 2);
    CHECK(source.scenes[0].pairs.size() == 1);
    return source.left_out.at(0).problem;
  };
  CHECK(Has(error("1 2 3\n"), "0001.jpg.camera: expected 26 numbers"));
  CHECK(Has(error("1 2 three\n"), "0001.jpg.camera:1"));
  std::string distorted = good;
  distorted.replace(distorted.find("0 0 0\n"), 5, "0 0 1");
  CHECK(Has(error(distorted), "undistorted"));
  for (const char* focal : {"-inf", "nan", "0", "-500"})
    CHECK(Has(error(focal + good.substr(3)), "0001.jpg: expected a calibration matrix"));
  std::filesystem::remove(path);
  CHECK(Has(ReadStrecha(root).left_out.at(0).problem, "0001.jpg.camera"));
  std::filesystem::remove(root + "/gt_dense_cameras/0000.jpg.camera");
  CHECK(Has(ErrorOf([&] { ReadStrecha(root); }), "2 images were left out"));
  CHECK(Has(ErrorOf([&] { ReadStrecha(folder / "nowhere"); }), "no such folder"));
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
  CHECK(source.images[0].camera->p2 == 0.4);
  CHECK(source.images[0].camera->K == Calibration(500, 510, 4.5, 3.5));
  const LensCamera& camera = *source.images[1].camera;
  CHECK(camera.K == Calibration(500, 500, 4.5, 3.5));
  CHECK(camera.k1 == -0.03);
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

TEST_CASE("NeRF: OpenGL's axes, calibration for all or a frame, frames that are left out") {
  TemporaryFolder folder;
  const std::string root = folder / "fox";
  MakeFolder(root + "/images");
  for (const char* name : {"0001.jpg", "0002.png", "0003.jpg"}) WriteSmall(root + "/images/" + name);
  // At (1, 2, 3), looking along +y of the world: OpenGL's backwards axis is -y, its up is z.
  const std::string matrix = "[[1, 0, 0, 1], [0, 0, -1, 2], [0, 1, 0, 3], [0, 0, 0, 1]]";
  const auto frame = [](const std::string& file, const std::string& transform, const std::string& more = "") {
    return "{\"file_path\": \"" + file + "\", \"transform_matrix\": " + transform + more + "}";
  };
  const auto write = [&](const std::string& frames, const std::string& calibration) {
    WriteRaw(root + "/transforms.json", "{" + calibration + ", \"frames\": [" + frames + "]}");
  };
  const std::string calibration =
      "\"fl_x\": 500, \"fl_y\": 510, \"cx\": 5, \"cy\": 4, \"w\": 10.0, \"h\": 8, \"k1\": 0.1";
  write(frame("./images/0002", matrix) + "," + frame("images/0001.jpg", matrix, ", \"fl_x\": 600"), calibration);
  const ImageSource source = ReadNerf(root);
  REQUIRE(source.images.size() == 2);
  CHECK(source.scenes[0].name == "fox");
  CHECK(source.images[0].name == "0001");
  CHECK(source.images[0].camera->K == Calibration(600, 510, 4.5, 3.5));
  CHECK(source.images[1].camera->K == Calibration(500, 510, 4.5, 3.5));
  CHECK(Has(source.images[1].path, "0002.png"));
  CHECK(source.images[1].camera->k1 == 0.1);
  CHECK(source.images[1].camera->size == ImageSize{10, 8});
  // A point 4 before the camera, 1 to the right and 2 above is at (1, -2, 4) in axes x right, y down, z forwards.
  const RigidMotion pose = *source.images[0].pose;
  CHECK((pose.rotation * Eigen::Vector3d(2, 6, 5) + pose.translation - Eigen::Vector3d(1, -2, 4)).norm() < 1e-12);
  CHECK(ReadNerf(root + "/transforms.json").scenes[0].name == "fox");

  // The focal length from the angle, the centre from the size.
  write(frame("images/0001.jpg", matrix) + "," + frame("images/0003.jpg", matrix),
        "\"camera_angle_x\": 1.5707963267948966, \"w\": 10, \"h\": 8");
  CHECK((ReadNerf(root).images[0].camera->K - Calibration(5, 5, 4.5, 3.5)).norm() < 1e-12);

  // Images of half the calibration's size, and beside the file instead of in a folder.
  std::filesystem::copy(root + "/images/0001.jpg", root + "/0007.jpg");
  write(frame("images/0007.jpg", matrix) + "," + frame("images/0003.jpg", matrix),
        "\"fl_x\": 1000, \"fl_y\": 1020, \"cx\": 10, \"cy\": 8, \"w\": 20, \"h\": 16");
  const ImageSource reduced = ReadNerf(root);
  REQUIRE(reduced.images.size() == 2);
  CHECK(reduced.images[1].path == root + "/0007.jpg");
  CHECK((reduced.images[1].camera->K - Calibration(500, 510, 4.5, 3.5)).norm() < 1e-12);
  CHECK(reduced.images[1].camera->size == ImageSize{10, 8});
  // Another shape is no reduced image, but a mistake that the check of sizes names.
  write(frame("images/0001.jpg", matrix) + "," + frame("images/0003.jpg", matrix),
        "\"fl_x\": 1000, \"cx\": 10, \"cy\": 8, \"w\": 20, \"h\": 8");
  CHECK(ReadNerf(root).images[0].camera->size == ImageSize{20, 8});

  const auto left_out = [&](const std::string& third) {
    write(frame("images/0001.jpg", matrix) + "," + frame("images/0003.jpg", matrix) + "," + third, calibration);
    const ImageSource read = ReadNerf(root);
    CHECK(read.images.size() == 2);
    return read.left_out.at(0).problem;
  };
  CHECK(Has(left_out(frame("images/0009.jpg", matrix)), "0009.jpg: no such file"));
  CHECK(Has(left_out(frame("images/0002.png", "[[1, 2], [3, 4]]")), "transform_matrix"));
  CHECK(Has(left_out(frame("images/0002.png", "\"identity\"")), "transform_matrix"));
  CHECK(Has(left_out(frame("images/0002.png", "[[1,0,0,0],[0,1,0,0],[0,0,0,0],[0,0,0,1]]")), "no rotation"));
  CHECK(Has(left_out("{\"sharpness\": 3}"), "file_path"));
  CHECK(Has(left_out("7"), "file_path"));
  CHECK(Has(left_out(frame("images/0002.png", matrix, ", \"fl_x\": \"long\"")), "expected a number as fl_x"));
  CHECK(Has(left_out(frame("images/0002.png", matrix, ", \"k3\": 0.5")), "k3"));

  const auto error = [&](const std::string& text) {
    WriteRaw(root + "/transforms.json", text);
    return ErrorOf([&] { ReadNerf(root); });
  };
  // An angle that is nearly none made an infinite focal length.
  for (const char* angle : {"1e-320", "0", "-1", "3.2"}) {
    write(frame("images/0001.jpg", matrix) + "," + frame("images/0003.jpg", matrix),
          std::string("\"camera_angle_x\": ") + angle + ", \"w\": 10, \"h\": 8");
    CHECK(Has(ErrorOf([&] { ReadNerf(root); }), "expected camera_angle_x"));
  }
  write(frame("images/0001.jpg", matrix) + "," + frame("images/0003.jpg", matrix),
        "\"fl_x\": 1e308, \"w\": 5, \"h\": 4");
  CHECK(Has(ErrorOf([&] { ReadNerf(root); }), "images were left out"));
  CHECK(Has(error("{\"frames\": ["), "transforms.json: not JSON"));
  CHECK(Has(error("[1, 2]"), "list of frames"));
  CHECK(Has(error("{\"frames\": []}"), "no pairs"));
  write(frame("images/0001.jpg", matrix) + "," + frame("images/0003.jpg", matrix), "\"w\": 10");
  CHECK(Has(ErrorOf([&] { ReadNerf(root); }), "2 images were left out"));
  CHECK(Has(ErrorOf([&] { ReadNerf(folder / "nowhere"); }), "nowhere"));
}

TEST_CASE("poses: in folders, or beside images and depth maps") {
  TemporaryFolder folder;
  const std::string brick = folder / "brick", kitchen = folder / "kitchen";
  for (const char* name : {"/image", "/pose", "/intrinsic"}) MakeFolder(brick + name);
  MakeFolder(kitchen);
  const std::string pose = "0 -1 0 4\n1 0 0 5\n0 0 1 6\n0 0 0 1\n";
  for (int i = 0; i < 3; ++i) {
    const std::string name = "00" + std::to_string(i);
    WriteSmall(brick + "/image/" + name + ".jpg");
    WriteRaw(brick + "/pose/" + name + ".txt", pose);
    WriteRaw(brick + "/intrinsic/" + name + ".txt", std::to_string(500 + i) + " 0 5\n0 500 4\n0 0 1\n");
    WriteSmall(kitchen + "/frame-" + name + ".color.png");
    WriteSmall(kitchen + "/frame-" + name + ".depth.png");
    WriteRaw(kitchen + "/frame-" + name + ".pose.txt", pose);
  }
  const ImageSource bricks = ReadPoses(brick, {});
  REQUIRE(bricks.images.size() == 3);
  CHECK(bricks.scenes[0].pairs.size() == 3);
  CHECK(bricks.images[2].camera->K == Calibration(502, 500, 5, 4));
  const RigidMotion motion = *bricks.images[2].pose;
  CHECK((motion.rotation * Eigen::Vector3d(4, 5, 6) + motion.translation).norm() < 1e-12);
  CHECK(motion.rotation(0, 1) == 1.0);

  const GivenCalibration given{"", 525, {320, 240}};
  const ImageSource frames = ReadPoses(kitchen, given);
  REQUIRE(frames.images.size() == 3);
  CHECK(frames.images[1].name == "frame_001.color");
  CHECK(frames.images[1].camera->K == Calibration(525, 525, 320, 240));
  CHECK(ReadPoses(brick, given).images[0].camera->K == Calibration(525, 525, 320, 240));

  WriteRaw(kitchen + "/frame-001.pose.txt", "-inf -inf -inf -inf\n0 0 0 0\n0 0 0 0\n0 0 0 1\n");
  WriteRaw(brick + "/pose/000.txt", "1 2 3\n");
  std::filesystem::remove(brick + "/intrinsic/001.txt");
  const auto problems = [](const ImageSource& source) {
    std::string text;
    for (const LeftOutImage& image : source.left_out) text += image.problem + "\n";
    return text;
  };
  CHECK(Has(problems(ReadPoses(kitchen, given)), "frame-001.pose.txt: the pose is not finite"));
  CHECK(Has(ErrorOf([&] { ReadPoses(brick, {}); }), "000.txt: expected a 4x4 matrix, found 3 numbers"));
  CHECK(ReadPoses(brick, given).left_out.size() == 1);
  WriteRaw(brick + "/pose/000.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 5 1\n");
  CHECK(Has(problems(ReadPoses(brick, given)), "0 0 0 1"));

  CHECK(Has(ErrorOf([&] { ReadPoses(kitchen, {}); }), "--focal"));
  CHECK(Has(ErrorOf([&] { ReadPoses(kitchen, {"", 525, {}}); }), "--center"));
  CHECK(Has(ErrorOf([&] { ReadPoses(kitchen, {"", -5, {1, 2}}); }), "positive --focal"));
  CHECK(Has(ErrorOf([&] { ReadPoses(kitchen, {"K.txt", 5, {1, 2}}); }), "excludes"));
  CHECK(Has(ErrorOf([&] { ReadPoses(folder / "nowhere", given); }), "no such folder"));
  MakeFolder(folder / "empty");
  CHECK(Has(ErrorOf([&] { ReadPoses(folder / "empty", given); }), "no images"));
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
