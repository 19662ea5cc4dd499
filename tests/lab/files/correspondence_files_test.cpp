#include "lab/files/correspondence_files.h"

#include <H5Cpp.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "core/errors.h"
#include "diffsac/core/parallel.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/two_view_test_util.h"
#include "lab/files/files.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {
namespace {

template <class A, class B>
bool Same(const A& a, const B& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && (a.array() == b.array()).all();
}

// A data set of doubles in a flat file, which is created when it is not there.
void PutRaw(const std::string& path, const std::string& key, const std::vector<hsize_t>& shape, double value = 1.0) {
  H5::H5File file(path, std::filesystem::exists(path) ? H5F_ACC_RDWR : H5F_ACC_TRUNC);
  if (file.nameExists(key)) file.unlink(key);
  std::size_t count = 1;
  for (hsize_t size : shape) count *= size;
  const std::vector<double> values(std::max<std::size_t>(count, 1), value);
  const H5::DataSpace space(static_cast<int>(shape.size()), shape.data());
  const H5::DataSet data = file.createDataSet(key, H5::PredType::NATIVE_DOUBLE, space);
  if (count > 0) data.write(values.data(), H5::PredType::NATIVE_DOUBLE);
}

std::string ReadErrorOf(const std::string& folder) {
  return ErrorOf([&] { CorrespondenceScene(folder).Read(0); });
}

bool OneLine(const std::string& text) { return !text.empty() && !Has(text, "\n"); }

}  // namespace

TEST_CASE("correspondences survive the way through the files without loss") {
  TemporaryFolder folder;
  CorrespondenceSet set = SyntheticSet(4, 30, Rng(1));
  set.pairs[2].problem.points(5, 1) = std::nan("");
  set.pairs[3].problem.points(0, 0) = 1e300;
  WriteCorrespondences(folder / "scene", set);
  CorrespondenceOptions options;
  options.descriptors = true;
  const CorrespondenceScene scene(folder / "scene/", options);
  CHECK(scene.scene() == "scene");
  REQUIRE(scene.size() == static_cast<std::int64_t>(set.pairs.size()));
  for (int i = 0; i < scene.size(); ++i) {
    const Example read = scene.Read(i);
    const Example& written = set.pairs[i];
    CAPTURE(written.id);
    CHECK(read.id == written.id);
    CHECK(read.problem.task == Task::kFundamental);  // What all two-view data is until a task is chosen.
    CHECK(read.scene == "scene");
    CHECK(read.image1 == written.image1);
    CHECK(read.image2 == written.image2);
    if (i == 2) {
      CHECK(std::isnan(read.problem.points(5, 1)));
      CHECK(Same(read.problem.points.topRows(5), written.problem.points.topRows(5)));
    } else {
      CHECK(Same(read.problem.points, written.problem.points));
    }
    CHECK(Same(read.problem.snn_ratio, written.problem.snn_ratio));
    CHECK(Same(read.problem.scale_rotation_changes, written.problem.scale_rotation_changes));
    CHECK(Same(read.problem.descriptors, written.problem.descriptors));
    REQUIRE(read.problem.cameras);
    CHECK(Same(read.problem.cameras->K1, written.problem.cameras->K1));
    CHECK(Same(read.problem.cameras->K2, written.problem.cameras->K2));
    CHECK(read.problem.size1 == written.problem.size1);
    CHECK(read.problem.size2 == written.problem.size2);
    REQUIRE(read.truth.motion);
    CHECK(*read.truth.motion == *written.truth.motion);
    CHECK(Same(*read.truth.essential, *written.truth.essential));
    CHECK(Same(*read.truth.fundamental, *written.truth.fundamental));
    CHECK(!read.truth.homography);
    CHECK(read.truth.assignment == written.truth.assignment);
  }
  // Descriptors are read only when they are asked for.
  CHECK(CorrespondenceScene(folder / "scene").Read(0).problem.descriptors.size() == 0);
  // Closed files open again.
  scene.CloseFiles();
  CHECK(Same(scene.Read(0).problem.points, set.pairs[0].problem.points));
}

TEST_CASE("matches alone are enough, and what can be derived is") {
  TemporaryFolder folder;
  CorrespondenceSet set = SyntheticSet(2, 10, Rng(2));
  const CorrespondenceSet full = set;
  set.cameras.clear();
  for (Example& pair : set.pairs) {
    pair.problem.snn_ratio.resize(0);
    pair.problem.scale_rotation_changes.resize(0, 2);
    pair.problem.descriptors.resize(0, 0);
    pair.problem.cameras.reset();
    pair.problem.size1 = {};
    pair.truth = {};
  }
  WriteCorrespondences(folder / "bare", set);
  CHECK(std::distance(std::filesystem::directory_iterator(folder / "bare"), {}) == 1);
  const Example bare = CorrespondenceScene(folder / "bare").Read(0);
  CHECK(!bare.problem.cameras);
  CHECK(bare.problem.snn_ratio.size() == 0);
  CHECK(bare.problem.size1 == ImageSize{});
  CHECK((!bare.truth.motion && !bare.truth.essential && !bare.truth.fundamental && bare.truth.assignment.empty()));
  CHECK(TruthDistances(bare.problem, bare.truth).size() == 0);

  set = full;
  for (Example& pair : set.pairs) pair.truth.essential.reset(), pair.truth.fundamental.reset();
  WriteCorrespondences(folder / "pose", set);
  const Example pose = CorrespondenceScene(folder / "pose").Read(0);
  CHECK(pose.truth.essential->isApprox(*full.pairs[0].truth.essential, 1e-12));
  CHECK(pose.truth.fundamental->isApprox(*full.pairs[0].truth.fundamental, 1e-12));

  // The first set again in the folder of a fuller one: nothing of that one may remain.
  WriteCorrespondences(folder / "full", full);
  set.cameras.clear();
  for (Example& pair : set.pairs) pair.truth = {}, pair.problem.snn_ratio.resize(0);
  WriteCorrespondences(folder / "full", set);
  const Example again = CorrespondenceScene(folder / "full").Read(0);
  CHECK(!again.truth.fundamental);
  CHECK(again.problem.snn_ratio.size() == 0);
}

TEST_CASE("a pair without matches goes with the others") {
  TemporaryFolder folder;
  CorrespondenceSet set = SyntheticSet(3, 12, Rng(3));
  Example& empty = set.pairs[1];
  empty.problem.points.resize(0, 4);
  empty.problem.snn_ratio.resize(0);
  empty.problem.scale_rotation_changes.resize(0, 2);
  empty.problem.descriptors.resize(0, 8);
  empty.truth.assignment.clear();
  WriteCorrespondences(folder / "scene", set);
  const CorrespondenceScene scene(folder / "scene");
  CHECK(scene.Read(1).problem.points.rows() == 0);
  CHECK(scene.Read(1).problem.points.cols() == 4);
  CHECK(scene.Read(2).problem.snn_ratio.size() == 12);
}

TEST_CASE("correspondences from elsewhere: other types and shapes, a homography's key") {
  TemporaryFolder folder;
  const std::string path = folder / "scene";
  std::filesystem::create_directory(path);
  {
    H5::H5File file(path + "/matches.h5", H5F_ACC_TRUNC);
    const hsize_t shape[2] = {2, 4};
    const float points[8] = {1, 2, 3, 4, 5, 6, 7.5f, 8};
    file.createDataSet("v_artisans_1_6", H5::PredType::NATIVE_FLOAT, H5::DataSpace(2, shape))
        .write(points, H5::PredType::NATIVE_FLOAT);
  }
  PutRaw(path + "/match_conf.h5", "v_artisans_1_6", {2, 1}, 0.5);
  PutRaw(path + "/K1_K2.h5", "v_artisans_1_6", {1, 2, 3, 3}, 0.0);
  CHECK(Has(ReadErrorOf(path), "calibration"));
  std::filesystem::remove(path + "/K1_K2.h5");
  PutRaw(path + "/Hgt.h5", "v_artisans_1_6", {3, 3}, 0.5);
  const Example pair = CorrespondenceScene(path).Read(0);
  CHECK(pair.id == "v_artisans_1_6");
  CHECK(pair.image1.empty());
  CHECK(pair.problem.points(1, 2) == 7.5);
  CHECK(pair.problem.snn_ratio == Eigen::Vector2d(0.5, 0.5));
  CHECK(*pair.truth.homography == Eigen::Matrix3d::Constant(0.5));
  PutRaw(path + "/R.h5", "v", {3, 3});
  PutRaw(path + "/T.h5", "v", {3, 1});
  CHECK(Has(ReadErrorOf(path), "img1-img2"));
}

TEST_CASE("Scores have a file of their own, beside which there are no ratios") {
  TemporaryFolder folder;
  CorrespondenceSet set = SyntheticSet(2, 20, Rng(4));
  const std::string path = folder / "scene", id = set.pairs[0].id;
  for (Example& pair : set.pairs) pair.problem.scored = true;
  WriteCorrespondences(path, set);
  CHECK_FALSE(std::filesystem::exists(path + "/match_conf.h5"));
  const Problem read = CorrespondenceScene(path).Read(0).problem;
  CHECK(read.scored);
  CHECK(read.snn_ratio.isApprox(set.pairs[0].problem.snn_ratio, 1e-15));
  for (const auto& [shape, value, error] :
       {std::tuple(19, 0.5, "expected 20 values"), std::tuple(20, 1.5, "expected scores from 0 to 1"),
        std::tuple(20, std::nan(""), "expected scores from 0 to 1")}) {
    PutRaw(path + "/match_scores.h5", id, {static_cast<hsize_t>(shape)}, value);
    CHECK(Has(ReadErrorOf(path), "match_scores.h5: " + id + ": " + error));
  }
  PutRaw(path + "/match_conf.h5", id, {20}, 0.5);
  CHECK(Has(ReadErrorOf(path), "match_scores.h5: expected ratios, match_conf.h5, or scores, found both"));
  set.pairs[1].problem.scored = false;
  CHECK(Has(ErrorOf([&] { WriteCorrespondences(path, set); }), "match_conf.h5: only 1 of 2"));
}

TEST_CASE("missing, truncated and wrong files are named with their data set") {
  TemporaryFolder folder;
  const CorrespondenceSet set = SyntheticSet(2, 20, Rng(4));
  const std::string path = folder / "scene", id = set.pairs[0].id, image = set.pairs[0].image1;
  const auto fresh = [&] { WriteCorrespondences(path, set); };
  const auto expect = [&](const std::string& file, const std::string& key, const std::string& part) {
    const std::string error = ReadErrorOf(path);
    CAPTURE(file, key, part, error);
    CHECK(OneLine(error));
    CHECK(Has(error, file));
    CHECK(Has(error, key));
    CHECK(Has(error, part));
    fresh();
  };
  fresh();
  REQUIRE(ReadErrorOf(path) == "");

  std::filesystem::remove(path + "/matches.h5");
  expect("matches.h5", "", "interrupted");
  std::filesystem::remove(path + "/T.h5");
  expect("T.h5", "", "no such file");
  CHECK(Has(ReadErrorOf(folder / "nowhere"), "no such folder"));

  PutRaw(path + "/matches.h5", id, {20, 3});
  expect("matches.h5", id, "20x3");
  PutRaw(path + "/match_conf.h5", id, {19});
  expect("match_conf.h5", id, "expected 20");
  PutRaw(path + "/similarities.h5", id, {20}, 0.5);
  expect("similarities.h5", id, "expected 20x2");
  PutRaw(path + "/similarities.h5", id, {20, 2}, std::nan(""));
  expect("similarities.h5", id, "finite");
  PutRaw(path + "/K1_K2.h5", id, {3, 3});
  expect("K1_K2.h5", id, "3x3");
  PutRaw(path + "/Fgt.h5", id, {9, 2});
  expect("Fgt.h5", id, "9x2");
  PutRaw(path + "/Egt.h5", id, {3, 3}, std::nan(""));
  expect("Egt.h5", id, "finite");
  PutRaw(path + "/R.h5", image, {3, 3});
  expect("R.h5", image, "rotation");
  PutRaw(path + "/T.h5", image, {4});
  expect("T.h5", image, "3 values");
  PutRaw(path + "/labels.h5", id, {20}, -1.0);
  expect("labels.h5", id, "labels");
  PutRaw(path + "/sizes.h5", id, {2});
  expect("sizes.h5", id, "h1 w1 h2 w2");
  for (const char* file : {"match_conf.h5", "similarities.h5", "K1_K2.h5", "Fgt.h5", "sizes.h5"}) {
    H5::H5File(path + "/" + file, H5F_ACC_RDWR).unlink(id);
    expect(file, id, "no such data set");
  }
  H5::H5File(path + "/R.h5", H5F_ACC_RDWR).unlink(image);
  expect("R.h5", image, "no such data set");
  {
    H5::H5File file(path + "/Egt.h5", H5F_ACC_TRUNC);
    file.createGroup(id);
  }
  expect("Egt.h5", id, "data set");
  { H5::H5File file(path + "/matches.h5", H5F_ACC_TRUNC); }
  expect("matches.h5", "", "no pairs");
  for (const char* file : {"matches.h5", "match_conf.h5", "R.h5"}) {
    const std::string whole = ReadFile(path + "/" + file);
    WriteRaw(path + "/" + file, whole.substr(0, whole.size() / 2));
    expect(file, "", "truncated");
    WriteRaw(path + "/" + file, "no HDF5");
    expect(file, "", "HDF5");
  }
  const CorrespondenceScene scene(path);
  CHECK(Has(ErrorOf([&] { scene.Read(2); }), "no pair number 2"));
  CHECK(Has(ErrorOf([&] { scene.Read(-1); }), "no pair number"));
}

TEST_CASE("sets that cannot be written are refused and leave no readable folder") {
  TemporaryFolder folder;
  const std::string path = folder / "scene";
  const CorrespondenceSet good = SyntheticSet(3, 8, Rng(5));
  const auto error = [&](auto change) {
    CorrespondenceSet set = good;
    change(set);
    return ErrorOf([&] { WriteCorrespondences(path, set); });
  };
  CHECK(Has(error([](auto& s) { s.pairs.clear(); }), "no pairs"));
  CHECK(Has(error([](auto& s) { s.pairs[1].id = s.pairs[0].id; }), "two pairs"));
  CHECK(Has(error([](auto& s) { s.pairs[1].id = "a/b"; }), "name a data set"));
  CHECK(Has(error([](auto& s) { s.cameras.erase(s.pairs[1].image1); }), "camera"));
  CHECK(Has(error([](auto& s) { s.pairs[1].problem.snn_ratio.conservativeResize(3); }), "not N"));
  CHECK(Has(error([](auto& s) { s.pairs[1].problem.scale_rotation_changes.conservativeResize(3, 2); }), "not N"));
  CHECK(Has(error([](auto& s) { s.pairs[1].problem.scale_rotation_changes.resize(0, 0); }),
            "similarities.h5: only 2 of 3"));
  CHECK(Has(error([](auto& s) { s.pairs[1].problem.scale_rotation_changes(2, 1) = std::nan(""); }), "not finite"));
  CHECK(Has(error([](auto& s) { s.pairs[1].problem.points.conservativeResize(8, 3); }), "Nx4"));
  CHECK(Has(error([](auto& s) { s.pairs[1].truth.fundamental.reset(); }), "Fgt.h5: only 2 of 3"));
  CHECK(Has(error([](auto& s) { s.pairs[1].problem.snn_ratio.resize(0); }), "match_conf.h5: only 2 of 3"));
  CHECK(!std::filesystem::exists(path));
  // A mistake that is seen beforehand leaves an earlier set alone.
  WriteCorrespondences(path, good);
  error([](auto& s) { s.pairs[1].truth.fundamental.reset(); });
  CHECK(ReadErrorOf(path) == "");
  CHECK(Has(error([](auto& s) { s.descriptors = [](std::size_t) { return DescriptorMatrix(1, 2); }; }), "one row"));
  // A set that failed half-way is no set.
  CHECK(Has(ReadErrorOf(path), "interrupted"));
  for (const auto& entry : std::filesystem::directory_iterator(path))
    CHECK(!Has(entry.path().filename().string(), ".tmp-"));
  WriteRaw(folder / "file", "x");
  CHECK(ErrorOf([&] { WriteCorrespondences(folder / "file/scene", good); }) != "");
}

TEST_CASE("descriptors may come one pair at a time") {
  TemporaryFolder folder;
  CorrespondenceSet set = SyntheticSet(2, 6, Rng(6));
  set.descriptors = [](std::size_t i) { return DescriptorMatrix(DescriptorMatrix::Constant(6, 4, i + 0.5f)); };
  WriteCorrespondences(folder / "scene", set);
  const CorrespondenceScene scene(folder / "scene", {true});
  CHECK(scene.Read(0).problem.descriptors == DescriptorMatrix::Constant(6, 4, 0.5f));
  CHECK(scene.Read(0).problem.descriptors.cols() == 4);
}

TEST_CASE("scenes can be read and written by several threads at once") {
  TemporaryFolder folder;
  const CorrespondenceSet set = SyntheticSet(5, 40, Rng(7));
  WriteCorrespondences(folder / "a", set);
  const CorrespondenceScene scene(folder / "a");
  std::vector<int> same(64);
  ParallelFor(64, 8, [&](std::int64_t i) {
    if (i % 16 == 0) WriteCorrespondences(folder / ("copy" + std::to_string(i)), set);
    const Example read = scene.Read(i % scene.size());
    const CorrespondenceScene own(folder / "a");
    same[i] = Same(read.problem.points, set.pairs[i % scene.size()].problem.points) &&
              Same(own.Read(0).problem.points, set.pairs[0].problem.points);
  });
  CHECK(std::count(same.begin(), same.end(), 1) == 64);
}

}  // namespace diffsac
