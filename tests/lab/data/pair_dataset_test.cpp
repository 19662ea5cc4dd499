#include "lab/data/pair_dataset.h"

#include <H5Cpp.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <set>

#include "core/errors.h"
#include "diffsac/core/parallel.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/problem/tasks.h"
#include "guidance/captured_log.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/example_test_util.h"
#include "lab/data/pair_check.h"
#include "lab/data/synthetic_two_view.h"
#include "lab/data/two_view_test_util.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

// How the tutorial's files may look: their element types are not documented.
struct Variant {
  bool float32 = false;
  bool column = false;  // match_conf (N, 1) and T (3, 1) instead of (N,) and (3,)
};

class TutorialFile {
 public:
  TutorialFile(const std::string& path, bool float32) : file_(path, H5F_ACC_TRUNC), float32_(float32) {}

  template <class Matrix>
  void Put(const std::string& key, const Matrix& values, std::vector<hsize_t> shape) {
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows = values;
    const H5::DataSpace space(static_cast<int>(shape.size()), shape.data());
    const auto& stored = float32_ ? H5::PredType::IEEE_F32LE : H5::PredType::IEEE_F64LE;
    file_.createDataSet(key, stored, space).write(rows.data(), H5::PredType::NATIVE_DOUBLE);
  }

 private:
  H5::H5File file_;
  bool float32_;
};

// A scene of the E and F tracks with three pairs of different N, seen by three cameras of which the first is the world.
std::vector<Example> WriteScene(const std::string& folder, std::uint64_t seed, const Variant& variant = {}) {
  const std::lock_guard lock(Hdf5Mutex());
  std::filesystem::create_directories(folder);
  const auto open = [&](const char* name) { return TutorialFile(folder + "/" + name, variant.float32); };
  auto matches = open("matches.h5"), conf = open("match_conf.h5"), K = open("K1_K2.h5"), R = open("R.h5"),
       T = open("T.h5"), E = open("Egt.h5"), F = open("Fgt.h5");
  const auto column = [&](hsize_t n) { return variant.column ? std::vector<hsize_t>{n, 1} : std::vector<hsize_t>{n}; };
  R.Put("im_0", Eigen::Matrix3d::Identity(), {3, 3});
  T.Put("im_0", Eigen::Vector3d::Zero(), column(3));
  std::vector<Example> examples;
  for (int i = 0; i < 3; ++i) {
    SyntheticTwoViewOptions options;
    options.task = Task::kEssential;
    options.matches.num_points = 40 + 10 * i;
    options.planar = 0.0;
    examples.push_back(MakeSyntheticTwoView(options, seed)->Get(i));
    const Example& e = examples.back();
    const std::string image = "im_" + std::to_string(i + 1), key = "im_0-" + image;
    const auto n = static_cast<hsize_t>(e.problem.points.rows());
    matches.Put(key, e.problem.points, {n, 4});
    conf.Put(key, e.problem.snn_ratio, column(n));
    Eigen::Matrix<double, 6, 3> both;
    both << e.problem.cameras->K1, e.problem.cameras->K2;
    K.Put(key, both, {1, 2, 3, 3});
    R.Put(image, e.truth.pose->rotation, {3, 3});
    T.Put(image, Eigen::Vector3d(3.0 * e.truth.pose->translation), column(3));
    const Eigen::Matrix3d essential = AsMatrix(e.truth.model);
    E.Put(key, essential, {3, 3});
    F.Put(key, FundamentalFromEssential(essential, e.problem.cameras->K1, e.problem.cameras->K2), {3, 3});
  }
  return examples;
}

std::unique_ptr<Dataset> Make(const std::string& type, const std::string& root, const std::string& more = "",
                              std::uint64_t seed = 1) {
  return MakeDataset(ConfigFromYaml("type: " + type + "\nroot: \"" + root + "\"\n" + more, "my.yaml"), seed);
}

void Unlink(const std::string& path, const std::string& key) {
  const std::lock_guard lock(Hdf5Mutex());
  H5::H5File(path, H5F_ACC_RDWR).unlink(key);
}

void Replace(const std::string& path, const std::string& key, std::vector<hsize_t> shape) {
  Unlink(path, key);
  const std::lock_guard lock(Hdf5Mutex());
  H5::H5File file(path, H5F_ACC_RDWR);
  std::size_t count = 1;
  for (hsize_t size : shape) count *= size;
  const H5::DataSpace space(static_cast<int>(shape.size()), shape.data());
  const H5::DataSet data = file.createDataSet(key, H5::PredType::NATIVE_DOUBLE, space);
  const std::vector<double> values(count, 1.0);
  if (count > 0) data.write(values.data(), H5::PredType::NATIVE_DOUBLE);
}

}  // namespace

TEST_CASE("the tutorial's layout is read in its variants, for E and F") {
  for (const Variant& variant :
       {Variant{false, false}, Variant{true, false}, Variant{false, true}, Variant{true, true}}) {
    CAPTURE(variant.float32, variant.column);
    const TemporaryFolder folder;
    const auto written = WriteScene(folder / "val/sacre_coeur", 3, variant);
    const double tolerance = variant.float32 ? 1e-3 : 1e-12;
    const auto essential = Make("ransac_tutorial", folder.path(), "task: essential\n");
    const auto fundamental = Make("ransac_tutorial", folder.path(), "inlier_threshold_px: 2\n");
    REQUIRE(essential->size() == 3);
    REQUIRE(fundamental->size() == 3);
    for (int i = 0; i < 3; ++i) {
      const Example e = essential->Get(i), f = fundamental->Get(i);
      CHECK(e.scene == "sacre_coeur");
      CHECK(e.id == "sacre_coeur/im_0-im_" + std::to_string(i + 1));
      CHECK(e.index == static_cast<std::uint64_t>(i));
      CHECK((e.problem.points - written[i].problem.points).cwiseAbs().maxCoeff() < tolerance);
      CHECK((e.problem.snn_ratio - written[i].problem.snn_ratio).cwiseAbs().maxCoeff() < tolerance);
      CHECK(e.problem.cameras->K2.isApprox(written[i].problem.cameras->K2, 1e-6));
      CHECK(std::abs(e.truth.model.dot(written[i].truth.model)) == Approx(1.0).margin(tolerance));
      CHECK(RotationAngleDegrees(e.truth.pose->rotation, written[i].truth.pose->rotation) < 1e-3);
      CHECK(DirectionAngleDegrees(e.truth.pose->translation, written[i].truth.pose->translation) < 1e-3);
      CHECK(f.problem.inlier_threshold == 2.0);
      const double from_truth = Fundamental::Residual(Matrix3Parameters(f.truth.model), f.problem.points.data());
      CHECK(f.truth.inliers[0] == (from_truth <= 2.0));
      CHECK(f.truth.inliers.size() == static_cast<std::size_t>(f.problem.points.rows()));
    }
  }
}

// Numbers of a file's data set in place of those that it has.
template <class Change>
void ChangeNumbers(const std::string& path, const std::vector<std::string>& keys, const Change& change) {
  const std::lock_guard lock(Hdf5Mutex());
  H5::H5File file(path, H5F_ACC_RDWR);
  for (const std::string& key : keys) {
    H5::DataSet data = file.openDataSet(key);
    std::vector<double> values(static_cast<std::size_t>(data.getSpace().getSimpleExtentNpoints()));
    data.read(values.data(), H5::PredType::NATIVE_DOUBLE);
    change(&values);
    data.write(values.data(), H5::PredType::NATIVE_DOUBLE);
  }
}

const std::vector<std::string> kPairs = {"im_0-im_1", "im_0-im_2", "im_0-im_3"}, kImages = {"im_1", "im_2", "im_3"};

struct Broken {
  TemporaryFolder folder;
  std::string scene = folder / "scene";
  Broken() { WriteScene(scene, 3); }
  std::string Said(const std::string& task = "essential") const {
    const std::string yaml = "{type: correspondences, task: " + task + ", paths: ['" + scene + "']}";
    std::string error;
    const std::string log = CapturedLog([&] { error = ErrorOf([&] { MakeDataset(ConfigFromYaml(yaml), 1); }); });
    return error + log;
  }
  std::string File(const std::string& name) const { return scene + "/" + name; }
  void Remove(const std::vector<std::string>& names) const {
    for (const std::string& name : names) std::filesystem::remove(File(name));
  }
};

TEST_CASE("ratios outside their range are an error") {
  const Broken broken;
  CHECK(broken.Said().empty());
  ChangeNumbers(broken.File("match_conf.h5"), kPairs, [](std::vector<double>* ratios) {
    for (double& ratio : *ratios) ratio = 1.0 + ratio;
  });
  CHECK(Has(broken.Said(), "scene/match_conf.h5: 150 of 150 ratios are not in [0, 1]"));
}

TEST_CASE("transposed rotations are told of") {
  const Broken broken;
  broken.Remove({"Egt.h5", "Fgt.h5"});
  CHECK(broken.Said().empty());
  ChangeNumbers(broken.File("R.h5"), kImages, [](std::vector<double>* R) {
    for (const auto& [a, b] : {std::pair(1, 3), std::pair(2, 6), std::pair(5, 7)}) std::swap((*R)[a], (*R)[b]);
  });
  CHECK(Has(broken.Said(), "scene: of 150 matches "));
}

TEST_CASE("matches that are all wrong are told of") {
  const Broken broken;
  ChangeNumbers(broken.File("matches.h5"), kPairs, [](std::vector<double>* points) {
    std::rotate(points->begin(), points->begin() + 4, points->end());
    // Each first point with another's second one.
    for (std::size_t i = 0; i + 8 <= points->size(); i += 8)
      std::swap_ranges(points->begin() + static_cast<std::ptrdiff_t>(i),
                       points->begin() + static_cast<std::ptrdiff_t>(i) + 2,
                       points->begin() + static_cast<std::ptrdiff_t>(i) + 4);
  });
  CHECK(Has(broken.Said(), " px of the truth: R.h5, T.h5 or K1_K2.h5 may be of another convention"));
}

TEST_CASE("a scene without truth or baseline is told of") {
  const Broken broken;
  ChangeNumbers(broken.File("T.h5"), kImages, [](std::vector<double>* T) { T->assign(3, 0.0); });
  CHECK(
      broken.Said().ends_with("scene/T.h5: 3 of 3 pairs have no baseline: no direction of t is right there, and any "
                              "counts as 0 degrees off\n"));
  broken.Remove({"R.h5", "T.h5", "Egt.h5", "Fgt.h5"});
  const auto dataset = MakeDataset(ConfigFromYaml("{type: correspondences, paths: ['" + broken.scene + "']}"), 1);
  CHECK(
      Has(CapturedLog([&] { WarnOfMissingTruth(*dataset); }), "scene: no truth of task fundamental (R.h5 and T.h5, "));
}

TEST_CASE("the same folder twice is an error") {
  const Broken broken;
  for (const std::string& again : {broken.scene + "/", broken.scene + "/../scene", std::string(broken.folder.path())})
    CHECK(Has(ErrorOf([&] {
                MakeDataset(ConfigFromYaml("{type: correspondences, paths: ['" + broken.scene + "', '" + again + "']}"),
                            1);
              }),
              "is there twice"));
}

TEST_CASE("the tutorial's splits and scenes are chosen by name") {
  const TemporaryFolder folder;
  WriteScene(folder / "train/b", 1);
  WriteScene(folder / "train/a", 2);
  WriteScene(folder / "val/c", 3);
  CHECK(Make("ransac_tutorial", folder.path(), "split: train\n")->size() == 6);
  CHECK(Make("ransac_tutorial", folder.path(), "split: train\n")->Get(0).scene == "a");
  CHECK(Make("ransac_tutorial", folder.path(), "split: train\nscenes: [b, a]\n")->Get(0).scene == "b");
  CHECK(Make("ransac_tutorial", folder.path(), "split: train\nscenes: [b]\nmax_pairs: 2\n")->size() == 2);
  CHECK(Make("ransac_tutorial", folder.path(), "split: validation\n")->Get(0).scene == "c");
  CHECK(Make("ransac_tutorial", folder.path())->Get(0).scene == "c");
  const auto error = [&](const std::string& more) {
    return ErrorOf([&] { Make("ransac_tutorial", folder.path(), more); });
  };
  CHECK(Has(error("split: test\n"), "test: no scenes"));
  CHECK(Has(error("split: trian\n"), "train"));
  CHECK(Has(error("split: train\nscenes: [aa]\n"), "did you mean 'a'"));
  CHECK(Has(ErrorOf([] { Make("ransac_tutorial", "nowhere"); }),
            "'nowhere': no such file or folder; looked for nowhere"));
  CHECK(Has(ErrorOf([] { MakeDataset(ConfigFromYaml("type: ransac_tutorial\n"), 1); }), "root"));
}

TEST_CASE("the tutorial's homographies are read from either level") {
  const TemporaryFolder folder;
  const auto write = [](const std::string& path, const std::string& key) {
    const std::lock_guard lock(Hdf5Mutex());
    std::filesystem::create_directories(path);
    SyntheticTwoViewOptions options;
    options.task = Task::kHomography;
    const Example example = MakeSyntheticTwoView(options, 4)->Get(0);
    const auto n = static_cast<hsize_t>(example.problem.points.rows());
    TutorialFile(path + "/matches.h5", true).Put(key, example.problem.points, {n, 4});
    TutorialFile(path + "/match_conf.h5", true).Put(key, example.problem.snn_ratio, {n});
    TutorialFile(path + "/Hgt.h5", false).Put(key, AsMatrix(example.truth.model), {3, 3});
    return example;
  };
  const Example written = write(folder / "EVD/val", "adam");
  write(folder / "HPatchesSeq/val", "v_artisans_1_6");
  const auto both = Make("ransac_tutorial", folder.path(), "task: homography\n");
  REQUIRE(both->size() == 2);
  CHECK(both->Get(0).id == "EVD/adam");
  CHECK(both->Get(1).id == "HPatchesSeq/v_artisans_1_6");
  CHECK(std::abs(both->Get(0).truth.model.dot(written.truth.model)) == Approx(1.0));
  const auto one = Make("ransac_tutorial", folder / "EVD", "task: homography\n");
  REQUIRE(one->size() == 1);
  CHECK(one->Get(0).scene == "EVD");
  CHECK(Has(ErrorOf([&] { Make("ransac_tutorial", folder / "EVD", "task: essential\n")->Get(0); }), "adam"));
}

TEST_CASE("matches are filtered, capped and shuffled, the same way each time") {
  const TemporaryFolder folder;
  const auto written = WriteScene(folder / "val/s", 5);
  const auto get = [&](const std::string& more) { return Make("ransac_tutorial", folder.path(), more)->Get(2); };
  const Eigen::VectorXd& ratios = written[2].problem.snn_ratio;
  const Example filtered = get("snn_threshold: 0.8\n");
  CHECK(filtered.problem.points.rows() == (ratios.array() <= 0.8).count());
  CHECK(filtered.problem.snn_ratio.maxCoeff() <= 0.8);
  CHECK(filtered.truth.inliers.size() == static_cast<std::size_t>(filtered.problem.points.rows()));
  const Example best = get("max_points: 15\n"), random = get("max_points: 15\ncap: random\n");
  Eigen::VectorXd sorted = ratios;
  std::sort(sorted.begin(), sorted.end());
  REQUIRE(best.problem.points.rows() == 15);
  CHECK(best.problem.snn_ratio.maxCoeff() <= sorted[14]);
  REQUIRE(random.problem.points.rows() == 15);
  CHECK(random.problem.snn_ratio.maxCoeff() > sorted[14]);
  CHECK(get("max_points: 15\ncap: random\n").problem.points == random.problem.points);
  const Example plain = get(""), shuffled = get("shuffle_points: true\n");
  CHECK_FALSE(testing::SamePoints(shuffled.problem.points, plain.problem.points));
  CHECK(get("shuffle_points: true\n").problem.points == shuffled.problem.points);
  // Each row took its ratio and mark along.
  for (Eigen::Index i = 0; i < plain.problem.points.rows(); ++i) {
    Eigen::Index at = 0;
    (shuffled.problem.points.rowwise() - plain.problem.points.row(i)).rowwise().norm().minCoeff(&at);
    CHECK(shuffled.problem.snn_ratio[at] == plain.problem.snn_ratio[i]);
    CHECK(shuffled.truth.inliers[at] == plain.truth.inliers[i]);
  }
}

TEST_CASE("pairs can be shuffled by the seed and read by several threads") {
  const TemporaryFolder folder;
  for (int scene = 0; scene < 4; ++scene) WriteScene(folder / ("val/s" + std::to_string(scene)), scene);
  const auto order = [&](std::uint64_t seed) {
    const auto dataset = Make("ransac_tutorial", folder.path(), "shuffle: true\n", seed);
    std::vector<std::string> ids(12);
    ParallelFor(12, 4, [&](std::int64_t i) { ids[i] = dataset->Get(i).id; });
    return ids;
  };
  const auto first = order(1);
  CHECK(std::set<std::string>(first.begin(), first.end()).size() == 12);
  CHECK(!std::is_sorted(first.begin(), first.end()));
  CHECK(order(1) == first);
  CHECK(order(2) != first);
}

TEST_CASE("what is wrong with a tutorial file is named with file and key, when the pair is read") {
  const TemporaryFolder folder;
  const std::string scene = folder / "val/s", key = "im_0-im_2";
  const auto expect = [&](const std::string& file, const std::string& part, const std::string& where) {
    // The listing alone succeeds: files are opened when a pair asks for them.
    const std::string error = ErrorOf([&] { Make("ransac_tutorial", folder.path(), "task: essential\n")->Get(1); });
    CAPTURE(file, error);
    CHECK(Has(error, file));
    CHECK(Has(error, part));
    CHECK(Has(error, where));
    CHECK(!Has(error, "\n"));
    WriteScene(scene, 6);
  };
  WriteScene(scene, 6);
  for (const char* file : {"match_conf.h5", "K1_K2.h5", "Egt.h5", "Fgt.h5"}) {
    Unlink(scene + "/" + file, key);
    expect(file, "no such data set", key);
  }
  Unlink(scene + "/R.h5", "im_2");
  expect("R.h5", "no such data set", "im_2");
  Replace(scene + "/matches.h5", key, {50, 3});
  expect("matches.h5", "expected Nx4", key);
  Replace(scene + "/match_conf.h5", key, {49});
  expect("match_conf.h5", "expected 50", key);
  Replace(scene + "/K1_K2.h5", key, {2, 3, 3});
  CHECK(Make("ransac_tutorial", folder.path())->Get(0).problem.cameras);
  WriteScene(scene, 6);
  Replace(scene + "/matches.h5", key, {0, 4});
  Replace(scene + "/match_conf.h5", key, {0});
  expect("matches.h5", "no matches", key);
  for (const char* file : {"match_conf.h5", "K1_K2.h5", "T.h5"}) {
    const std::string content = ReadFile(scene + "/" + file);
    WriteRaw(scene + "/" + file, content.substr(0, content.size() / 2));
    expect(file, "truncated", file);
  }
  std::filesystem::remove(scene + "/K1_K2.h5");
  expect("matches.h5", "K1_K2.h5", key);
  const std::string content = ReadFile(scene + "/matches.h5");
  WriteRaw(scene + "/matches.h5", content.substr(0, content.size() / 2));
  CHECK(Has(ErrorOf([&] { Make("ransac_tutorial", folder.path()); }), "matches.h5"));
}

TEST_CASE("a pair without matches may be kept") {
  const TemporaryFolder folder;
  const std::string scene = folder / "val/s";
  WriteScene(scene, 7);
  Replace(scene + "/matches.h5", "im_0-im_1", {0, 4});
  Replace(scene + "/match_conf.h5", "im_0-im_1", {0});
  const Example empty = Make("ransac_tutorial", folder.path(), "empty_pairs: keep\n")->Get(0);
  CHECK(empty.problem.points.rows() == 0);
  CHECK(CheckProblem(empty.problem) == Status::kTooFewPoints);
}

TEST_CASE("matches that are not finite are left out, or refused") {
  const TemporaryFolder folder;
  const std::string scene = folder / "val/s";
  std::vector<Example> written = WriteScene(scene, 7);
  PointMatrix& points = written[0].problem.points;
  points(3, 2) = std::nan("");
  Unlink(scene + "/matches.h5", "im_0-im_1");
  {
    const std::lock_guard lock(Hdf5Mutex());
    H5::H5File file(scene + "/matches.h5", H5F_ACC_RDWR);
    const hsize_t shape[2] = {static_cast<hsize_t>(points.rows()), 4};
    file.createDataSet("im_0-im_1", H5::PredType::NATIVE_DOUBLE, H5::DataSpace(2, shape))
        .write(points.data(), H5::PredType::NATIVE_DOUBLE);
  }
  const Example read = Make("ransac_tutorial", folder.path())->Get(0);
  CHECK(CheckProblem(read.problem) == Status::kOk);
  REQUIRE(read.problem.points.rows() == points.rows() - 1);
  CHECK(read.problem.points.row(3) == points.row(4));
  CHECK(read.problem.snn_ratio.size() == points.rows() - 1);
}

TEST_CASE("KITTI scenes are chosen by sequence and step") {
  const TemporaryFolder folder;
  for (const char* name : {"kitti_00_step_01", "kitti_00_step_10", "kitti_08_step_01", "kitti_x", "castle"})
    WriteScene(folder / name, 8);
  const auto scenes = [&](const std::string& more) {
    const auto dataset = Make("kitti", folder.path(), more);
    std::vector<std::string> names;
    for (int i = 0; i < dataset->size(); i += 3) names.push_back(dataset->Get(i).scene);
    return names;
  };
  using Names = std::vector<std::string>;
  CHECK(scenes("") == Names{"kitti_00_step_01", "kitti_00_step_10"});
  CHECK(scenes("steps: [10]\n") == Names{"kitti_00_step_10"});
  CHECK(scenes("sequences: [\"08\", \"09\", \"10\"]\n") == Names{"kitti_08_step_01"});
  CHECK(scenes("sequences: []\nsteps: [1]\n") == Names{"kitti_00_step_01", "kitti_08_step_01"});
  CHECK(Has(ErrorOf([&] { scenes("steps: [3]\n"); }), "diffsac_prepare"));
  const std::string text = WriteDatasetOptions(ConfigFromYaml("type: kitti\nroot: a\nsteps: [1, 5]\n"));
  CHECK(WriteDatasetOptions(ConfigFromYaml(text)) == text);
}

TEST_CASE("scenes of a folder are read through the factory, what is missing is named") {
  const TemporaryFolder folder;
  WriteCorrespondences(folder / "a", SyntheticSet(3, 40, Rng(1)));
  WriteCorrespondences(folder / "b", SyntheticSet(4, 40, Rng(2)));
  const auto make = [&](const std::string& more) {
    return MakeDataset(
        ConfigFromYaml("type: correspondences\npaths: [\"" + folder.path() + "\"]\n" + more, "test.yaml"), 1);
  };
  // Options that no configuration was read into are checked as well.
  CorrespondencesOptions wrong;
  wrong.paths = {folder.path()};
  wrong.pairs.filter.max_points = -5;
  CHECK_THROWS_AS(MakeCorrespondences(wrong, 1), Error);
  const auto dataset = make("task: essential\n");
  CHECK(dataset->task() == Task::kEssential);
  REQUIRE(dataset->size() == 7);
  CHECK(dataset->Get(0).scene == "a");
  CHECK(dataset->Get(6).scene == "b");
  CHECK(dataset->Get(6).index == 6);
  CHECK(dataset->Get(0).truth.pose->translation.norm() == Approx(1.0));
  CHECK(make("max_pairs: 2\n")->size() == 4);
  // Of three and four pairs the first half and the second, rounded, are all.
  const auto first = make("part: [0, 0.5]\n"), second = make("part: [0.5, 1]\n");
  CHECK(first->size() == 4);
  CHECK(second->size() == 3);
  CHECK(first->Get(0).id == dataset->Get(0).id);
  CHECK(second->Get(2).id == dataset->Get(6).id);
  CHECK(dataset->Get(0).problem.descriptors.size() == 0);
  CHECK(dataset->Get(0).problem.size2 == ImageSize{600, 400});
  // Descriptors go with their matches.
  const CorrespondenceSet written = SyntheticSet(3, 40, Rng(1));
  const Example few = make("descriptors: true\nmax_points: 7\n")->Get(0);
  REQUIRE(few.problem.descriptors.rows() == 7);
  for (int i = 0; i < 7; ++i)
    for (int k = 0; k < 40; ++k)
      if (written.pairs[0].problem.points.row(k) == few.problem.points.row(i))
        CHECK(few.problem.descriptors.row(i) == written.pairs[0].problem.descriptors.row(k));
  CHECK_THROWS_AS(make("min_points: 1000\n"), Error);
  CHECK_THROWS_AS(make("task: line\n"), Error);
  CHECK_THROWS_AS(MakeDataset(ConfigFromYaml("type: correspondences\npaths: [nowhere]\n", "test.yaml"), 1), Error);
}

}  // namespace diffsac
