#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/errors.h"
#include "lab/files/correspondence_files.h"
#include "lab/images/feature_file_test_util.h"
#include "lab/images/hloc_files.h"
#include "lab/images/image_test_util.h"
#include "lab/images/run_pairs.h"

namespace diffsac {

namespace fs = std::filesystem;

namespace {

using Vector = Eigen::VectorXd;

const std::atomic<bool> kNeverStop{false};

Vector Values(const std::vector<double>& values) { return Eigen::Map<const Vector>(values.data(), values.size()); }

Eigen::MatrixXd Keypoints(int count, double first) {
  Eigen::MatrixXd points(count, 2);
  for (int i = 0; i < count; ++i) points.row(i) << first + 10 * i, 5.5 + i;
  return points;
}

void PutFeatures(FeatureFile& file, const std::string& name, const Eigen::MatrixXd& keypoints) {
  file.Put(name + "/keypoints", keypoints);
  file.Put(name + "/scores", Vector::Ones(keypoints.rows()), true);
  file.Put(name + "/image_size", Eigen::Vector2d(320, 240), true);
}

void PutPair(FeatureFile& file, const std::string& pair, const std::vector<double>& partners,
             const std::vector<double>& scores) {
  file.Put(pair + "/matches0", Values(partners), true);
  file.Put(pair + "/matching_scores0", Values(scores), true);
}

// features.h5 with three images.
void WriteFeatures(const TemporaryFolder& folder) {
  WriteFeatureFile(folder / "features.h5", [](FeatureFile& file) {
    PutFeatures(file, "db/a_1.jpg", Keypoints(3, 1));
    PutFeatures(file, "db/b.jpg", Keypoints(4, 2));
    PutFeatures(file, "q.jpg", Keypoints(5, 3));
  });
}

PairsRequest RequestFor(const TemporaryFolder& folder, const char* input = "matches.h5") {
  PairsRequest request;
  request.format = "hloc";
  request.input = folder / input;
  request.output = folder / "pairs";
  return request;
}

// What reading matches says that `fill` has written.
template <class Fill>
std::string MatchesError(Fill fill) {
  TemporaryFolder folder;
  WriteFeatures(folder);
  WriteFeatureFile(folder / "matches.h5", fill);
  return ErrorOf([&] { RunPairs(RequestFor(folder), kNeverStop); });
}

}  // namespace

TEST_CASE("hloc: sizes and angles of keypoints, where all images have them") {
  for (const bool all : {true, false}) {
    TemporaryFolder folder;
    WriteFeatureFile(folder / "features.h5", [all](FeatureFile& file) {
      for (const std::string name : {"a.jpg", "b.jpg", "c.jpg"}) {
        PutFeatures(file, name, Keypoints(2, 1));
        if (!all && name == "c.jpg") continue;
        file.Put(name + "/scales", name == "a.jpg" ? Values({2, 3}) : Values({4, 5}), true);
        file.Put(name + "/oris", name == "a.jpg" ? Values({10, 350}) : Values({55, 10}), true);
      }
    });
    WriteFeatureFile(folder / "matches.h5", [](FeatureFile& file) {
      PutPair(file, "a.jpg/b.jpg", {1, 0}, {1, 1});
      PutPair(file, "b.jpg/c.jpg", {0, 1}, {1, 1});
    });
    REQUIRE(RunPairs(RequestFor(folder), kNeverStop).written == 1);
    const CorrespondenceScene scene(folder / "pairs/matches");
    const PointMatrix found = scene.Read(0).problem.scale_rotation_changes;
    REQUIRE(found.rows() == (all ? 2 : 0));
    if (!all) continue;
    CHECK(found(0, 0) == Approx(std::log(5.0 / 2.0)));
    CHECK(found(0, 1) == Approx(0.0).margin(1e-6));
    CHECK(found(1, 0) == Approx(std::log(4.0 / 3.0)));
    CHECK(found(1, 1) == Approx(65.0 * std::numbers::pi / 180.0));
    CHECK(scene.Read(1).problem.scale_rotation_changes.isZero());
  }
  TemporaryFolder folder;
  WriteFeatureFile(folder / "features.h5", [](FeatureFile& file) {
    PutFeatures(file, "a.jpg", Keypoints(2, 1));
    file.Put("a.jpg/scales", Values({2}), true);
    file.Put("a.jpg/oris", Values({10, 20}), true);
  });
  WriteFeatureFile(folder / "matches.h5", [](FeatureFile& file) { PutPair(file, "a.jpg/a.jpg", {1, 0}, {1, 1}); });
  CHECK(Has(ErrorOf([&] { RunPairs(RequestFor(folder), kNeverStop); }), "a.jpg/scales: expected 2 values"));
}

TEST_CASE("hloc: pairs in both forms of names, scores, sizes, a calibration") {
  TemporaryFolder folder;
  WriteFeatures(folder);
  WriteFeatureFile(folder / "matches.h5", [](FeatureFile& file) {
    PutPair(file, "q.jpg/db-a_1.jpg", {-1, 2, -1, 0, 1}, {0, 0.75, 0, 1, 0.5});
    PutPair(file, "db-a_1.jpg/q.jpg", {3, 4, 1}, {1, 1, 1});  // the same once more
    PutPair(file, "db-a_1.jpg_db-b.jpg", {3, -1, 0}, {0.25, 0, 0.125});
  });
  PairsRequest request = RequestFor(folder);
  request.calibration.focal = 300;
  request.calibration.center = {160, 120};
  REQUIRE(RunPairs(request, kNeverStop).written == 1);
  const CorrespondenceScene scene(folder / "pairs/matches");
  REQUIRE(scene.pairs() == std::vector<std::string>{"db_a_1-db_b", "db_a_1-q"});
  const Problem old = scene.Read(0).problem;
  REQUIRE(old.points.rows() == 2);
  CHECK(old.points.row(0) == Eigen::RowVector4d(1, 5.5, 32, 8.5));
  CHECK(old.points.row(1) == Eigen::RowVector4d(21, 7.5, 2, 5.5));
  CHECK(old.scored);
  CHECK(old.snn_ratio == Eigen::Vector2d(0.75, 0.875));
  CHECK_FALSE(fs::exists(folder / "pairs/matches/match_conf.h5"));
  CHECK(old.size1 == ImageSize{320, 240});
  REQUIRE(old.cameras);
  CHECK(old.cameras->K2(0, 2) == 160.0);
  CHECK(scene.ReadMatchIndices("db_a_1-db_b", 2) == (MatchIndices(2, 2) << 0, 3, 2, 0).finished());
  CHECK(scene.Read(1).problem.points.rows() == 3);
}

TEST_CASE("hloc: a folder with one file of each kind") {
  TemporaryFolder folder;
  fs::create_directory(folder / "outputs");
  const TemporaryFolder other;
  WriteFeatures(other);
  fs::copy_file(other / "features.h5", folder / "outputs/feats.h5");
  WriteFeatureFile(folder / "outputs/pairs-all.h5", [](FeatureFile& file) {
    file.Put("q.jpg/db-b.jpg/matches0", Values({-1, 2, -1, 0, 1}), true);
  });
  REQUIRE(RunPairs(RequestFor(folder, "outputs"), kNeverStop).written == 1);
  const Problem problem = CorrespondenceScene(folder / "pairs/outputs").Read(0).problem;
  CHECK(problem.points.rows() == 3);
  CHECK(problem.snn_ratio.size() == 0);
  fs::copy_file(other / "features.h5", folder / "outputs/others.h5");
  PairsRequest request = RequestFor(folder, "outputs");
  request.scene = "again";
  CHECK(Has(
      ErrorOf([&] { RunPairs(request, kNeverStop); }),
      "expected one .h5 file with hloc's features, found 2 (feats.h5, others.h5); name it with --import-descriptors"));
  request.options.import_descriptors = folder / "outputs/others.h5";
  CHECK(RunPairs(request, kNeverStop).written == 1);
  fs::create_directory(folder / "empty");
  CHECK(Has(ErrorOf([&] { RunPairs(RequestFor(folder, "empty"), kNeverStop); }), "hloc's matches, found none"));
  CHECK(Has(ErrorOf([&] { RunPairs(RequestFor(folder, "absent.h5"), kNeverStop); }), "absent.h5: no such file"));
}

TEST_CASE("hloc: an image whose keypoints are not finite, or a bad pair, costs no other") {
  TemporaryFolder folder;
  WriteFeatureFile(folder / "features.h5", [](FeatureFile& file) {
    Eigen::MatrixXd bad = Keypoints(3, 1);
    bad(1, 0) = std::nan("");
    PutFeatures(file, "a.jpg", Keypoints(3, 1));
    PutFeatures(file, "b.jpg", Keypoints(3, 2));
    PutFeatures(file, "c.jpg", bad);
    PutFeatures(file, "d.jpg", Keypoints(3, 3));
  });
  WriteFeatureFile(folder / "matches.h5", [](FeatureFile& file) {
    for (const char* pair : {"a.jpg/b.jpg", "a.jpg/c.jpg", "b.jpg/c.jpg"}) PutPair(file, pair, {0, 1, -1}, {1, 1, 1});
    PutPair(file, "a.jpg/d.jpg", {0, 7, -1}, {1, 1, 1});
  });
  const HlocFiles files = ReadHlocFiles(folder / "features.h5", folder / "matches.h5");
  REQUIRE(files.pairs.size() == 1);
  CHECK(Has(files.images[2].problem, "features.h5: c.jpg/keypoints: a value is not finite"));
  CHECK(files.of_bad_images == 2);
  REQUIRE(files.bad_pairs.size() == 1);
  CHECK(Has(files.bad_pairs[0], "a.jpg/d.jpg/matches0: 7 is no keypoint of d.jpg"));
  CHECK(RunPairs(RequestFor(folder), kNeverStop).written == 1);
  CHECK(CorrespondenceScene(folder / "pairs/matches").pairs() == std::vector<std::string>{"a-b"});

  // A scene does not replace what it is made of.
  PairsRequest request = RequestFor(folder);
  fs::create_directories(folder / "here");
  fs::rename(folder / "matches.h5", folder / "here/matches.h5");
  request.input = folder / "here/matches.h5";
  request.options.import_descriptors = folder / "features.h5";
  request.output = folder.path();
  request.scene = "here";
  request.options.overwrite = true;
  CHECK(Has(ErrorOf([&] { RunPairs(request, kNeverStop); }), "is an input"));
}

TEST_CASE("hloc: mistakes in matches") {
  const auto one = [](const std::string& pair, const std::vector<double>& partners, const std::vector<double>& scores) {
    return MatchesError([&](FeatureFile& file) { PutPair(file, pair, partners, scores); });
  };
  CHECK(one("q.jpg/db-b.jpg", {0, 1, 2, 3, -1}, {1, 1, 1, 1, 1}) == "");
  CHECK(Has(one("q.jpg/db-b.jpg", {0, 1, 2, 4, -1}, {1, 1, 1, 1, 1}),
            "matches.h5: q.jpg/db-b.jpg/matches0: 4 is no keypoint of db/b.jpg, which has 4"));
  CHECK(Has(one("q.jpg/db-b.jpg", {0, 1}, {1, 1}), "expected 5 values, one a keypoint of q.jpg, found 2"));
  CHECK(Has(one("q.jpg/db-b.jpg", {0, 1, 2, 3, -1}, {1, 1}), "matching_scores0: expected 5 values"));
  CHECK(Has(one("q.jpg/db-b.jpg", {0, 1, 2, 3, -1}, {1, 1, 2, 1, 1}), "expected scores from 0 to 1"));
  CHECK(Has(one("q.jpg/c.jpg", {0}, {1}), "features.h5 has no image c.jpg"));
  CHECK(Has(one("q.jpg_c.jpg", {0}, {1}), "has no two images of this name"));
  CHECK(Has(one("x/q.jpg/c.jpg", {0}, {1}), "expected NAME1/NAME2"));
  CHECK(Has(MatchesError([](FeatureFile& file) { file.Put("a/other", Values({1}), true); }),
            "no group of it holds matches0"));
}

TEST_CASE("hloc: mistakes in features, names that mean two things, no HDF5") {
  TemporaryFolder folder;
  WriteFeatureFile(folder / "matches.h5", [](FeatureFile& file) {
    file.Put("a_b_c/matches0", Values({-1, -1, -1}), true);
  });
  const auto error = [&] { return ErrorOf([&] { ReadHlocFiles(folder / "f.h5", folder / "matches.h5"); }); };
  WriteFeatureFile(folder / "f.h5", [](FeatureFile& file) {
    for (const char* name : {"a", "a_b", "c", "b_c"}) PutFeatures(file, name, Keypoints(3, 1));
  });
  CHECK(Has(error(), "matches.h5: a_b_c: can be the name of several pairs"));
  WriteFeatureFile(folder / "f.h5", [](FeatureFile& file) {
    for (const char* name : {"x/y", "x-y"}) PutFeatures(file, name, Keypoints(3, 1));
  });
  CHECK(Has(error(), "are the same in pairs"));
  WriteFeatureFile(folder / "f.h5", [](FeatureFile& file) { file.Put("a/keypoints", Eigen::MatrixXd::Zero(3, 3)); });
  CHECK(Has(error(), "f.h5: a/keypoints: expected Nx2, found 3x3"));
  WriteFeatureFile(folder / "f.h5", [](FeatureFile& file) { file.Put("a/descriptors", Eigen::MatrixXd::Zero(3, 3)); });
  CHECK(Has(error(), "no group of it holds keypoints"));
  WriteRaw(folder / "f.h5", "no HDF5");
  CHECK(Has(error(), "f.h5: not a readable HDF5 file"));
}

TEST_CASE("imported features: names, both ways to lie, the strongest") {
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

TEST_CASE("pairs from imported features are those from the same features found here") {
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
