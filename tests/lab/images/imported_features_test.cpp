#include <catch2/catch.hpp>
#include <filesystem>

#include "core/errors.h"
#include "lab/files/correspondence_files.h"
#include "lab/images/feature_file_test_util.h"
#include "lab/images/feature_store.h"
#include "lab/images/image_test_util.h"
#include "lab/images/run_pairs.h"

namespace diffsac {

namespace fs = std::filesystem;

namespace {

const std::atomic<bool> kNeverStop{false};

}  // namespace

TEST_CASE("imported features by name and both ways to lie") {
  TemporaryFolder folder;
  Eigen::MatrixXd keypoints(3, 2), descriptors(3, 4);
  keypoints << 1, 2, 30, 40, 319, 239.5;
  descriptors << 1, 0, 0, 0, 0, 3, 4, 0, 0, 0, 0, 2;
  const Eigen::Vector3d scores(0.1, 0.9, 0.5);
  WriteFeatureFile(folder / "f.h5", [&](FeatureFile& file) {
    file.Put("a.jpg/keypoints", keypoints);
    file.Put("a.jpg/descriptors", descriptors.transpose());
    file.Put("a.jpg/scores", scores, true);
    file.Put("a.jpg/image_size", Eigen::Vector2d(320, 240), true);
    file.Put("db/images/b.jpg/keypoints", keypoints);
    file.Put("db/images/b.jpg/descriptors", descriptors);
    file.Put("c/keypoints", keypoints);
    file.Put("c/descriptors", descriptors.transpose());
    file.Put("empty.png/keypoints", Eigen::MatrixXd(0, 2));
    file.Put("empty.png/descriptors", Eigen::MatrixXd(4, 0));
  });
  const ImportedFeatures imported(folder / "f.h5");
  const ImageSize size{320, 240};
  const ImageFeatures a = imported.Read("/data/images/a.jpg", size, 0);
  REQUIRE(a.positions.rows() == 3);
  CHECK(a.size == size);
  // By score; of unit length.
  CHECK(a.positions(0, 0) == 30.0);
  CHECK(a.descriptors(0, 1) == Approx(0.6));
  CHECK(a.descriptors(2, 0) == 1.0f);
  CHECK(imported.Read("a.jpg", size, 2).positions.rows() == 2);
  const ImageFeatures b = imported.Read("/data/db/images/b.jpg", size, 0);
  CHECK(b.positions(0, 0) == 1.0);
  CHECK(b.descriptors(1, 2) == Approx(0.8));
  CHECK(imported.Read("x/c.png", size, 0).descriptors == b.descriptors);
  CHECK(imported.Read("empty.png", size, 0).positions.rows() == 0);

  const auto error = [&](const std::string& name, const ImageSize& s) {
    return ErrorOf([&] { imported.Read(name, s, 0); });
  };
  CHECK(Has(error("missing.jpg", size), "f.h5: there is no group missing.jpg"));
  CHECK(Has(error("a.jpg", {640, 480}), "f.h5: a.jpg/image_size: the image is 640x480"));
  CHECK(Has(error("db/images/b.jpg", {100, 100}), "b.jpg/keypoints: keypoint 2 lies outside the 100x100 image"));
  WriteFeatureFile(folder / "bad.h5", [&](FeatureFile& file) {
    file.Put("none/descriptors", descriptors);
    file.Put("half/keypoints", keypoints);
    file.Put("shape/keypoints", Eigen::MatrixXd::Zero(3, 3));
    file.Put("shape/descriptors", descriptors);
    file.Put("count/keypoints", keypoints);
    file.Put("count/descriptors", Eigen::MatrixXd::Zero(5, 4));
    file.Put("score/keypoints", keypoints);
    file.Put("score/descriptors", descriptors);
    file.Put("score/scores", Eigen::Vector2d(1, 2), true);
    file.Put("nan/keypoints", keypoints);
    file.Put("nan/descriptors", Eigen::MatrixXd::Constant(4, 3, std::nan("")));
    file.Put("data", keypoints);
  });
  const ImportedFeatures bad(folder / "bad.h5");
  const auto bad_error = [&](const std::string& name) { return ErrorOf([&] { bad.Read(name + ".png", size, 0); }); };
  CHECK(Has(bad_error("none"), "bad.h5: none: it has no keypoints"));
  CHECK(Has(bad_error("half"), "bad.h5: half: it has no descriptors"));
  CHECK(Has(bad_error("shape"), "shape/keypoints: expected Nx2, found 3x3"));
  CHECK(Has(bad_error("count"), "count/descriptors: expected DxN or NxD with N = 3, found 5x4"));
  CHECK(Has(bad_error("score"), "score/scores: expected 3 values"));
  CHECK(Has(bad_error("nan"), "nan/descriptors: a value is not finite"));
  CHECK(Has(bad_error("data"), "there is no group data.png"));
  CHECK(Has(ErrorOf([&] { ImportedFeatures(folder / "nowhere.h5"); }), "nowhere.h5: no such file"));
  WriteRaw(folder / "text.h5", "no HDF5");
  CHECK(Has(ErrorOf([&] { ImportedFeatures(folder / "text.h5"); }), "text.h5: not a readable HDF5 file"));
}

TEST_CASE("imported features match as those found here") {
  TemporaryFolder folder;
  fs::create_directories(folder / "plane");
  WriteImage(folder / "plane/1.png", Texture(320, 240, 8));
  WriteImage(folder / "plane/2.png", Texture(320, 240, 8)(cv::Rect(10, 5, 300, 230)));
  PairsRequest request;
  request.format = "images";
  request.input = folder / "plane";
  request.output = folder / "own";
  request.options.descriptors = true;
  REQUIRE(RunPairs(request, kNeverStop).finished);
  std::vector<ImageFeatures> features;
  for (const char* name : {"1", "2"})
    features.push_back(ExtractFeatures(request.input + "/" + name + ".png", request.options.features));
  WriteFeatureFile(folder / "f.h5", [&](FeatureFile& file) {
    for (int i = 0; i < 2; ++i) {
      const std::string name = std::to_string(i + 1) + ".png";
      file.Put(name + "/keypoints", features[i].positions);
      file.Put(name + "/descriptors", features[i].descriptors.cast<double>());
    }
  });
  request.output = folder / "imported";
  request.options.import_descriptors = folder / "f.h5";
  REQUIRE(RunPairs(request, kNeverStop).finished);
  CorrespondenceOptions options;
  options.descriptors = true;
  const Problem own = CorrespondenceScene(folder / "own/plane", options).Read(0).problem;
  const Problem imported = CorrespondenceScene(folder / "imported/plane", options).Read(0).problem;
  REQUIRE(own.points.rows() == imported.points.rows());
  REQUIRE(own.points.rows() > 60);
  CHECK((own.points - imported.points).cwiseAbs().maxCoeff() < 1e-4);
  CHECK((own.descriptors - imported.descriptors).cwiseAbs().maxCoeff() < 1e-6f);

  WriteImage(folder / "plane/3.png", Texture(100, 100, 8));
  request.output = folder / "other";
  // One image that the file does not have costs no other.
  const PrepareResult result = RunPairs(request, kNeverStop);
  CHECK(result.written == 1);
  REQUIRE(result.left_out.size() == 1);
  CHECK(Has(result.left_out[0], "f.h5: there is no group 3.png"));
}

}  // namespace diffsac
