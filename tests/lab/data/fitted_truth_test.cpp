#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/errors.h"
#include "core/temporary_folder.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/example_test_util.h"
#include "lab/data/fitted_truth.h"
#include "lab/data/pair_dataset.h"
#include "lab/data/pair_filter.h"
#include "lab/data/plane_pair.h"
#include "lab/data/two_view_test_util.h"
#include "lab/files/correspondence_files.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {
namespace {

constexpr int kOnPlane = 60, kElsewhere = 40, kWrong = 30;

// Two views of a plane, of points off it, and wrong matches.
Example PlanePair() {
  Rng rng(11);
  Example pair;
  pair.scene = "scene";
  pair.image1 = "a";
  pair.image2 = "b";
  pair.id = "a-b";
  const Eigen::Matrix3d K = Calibration(500, 500, 320, 240);
  pair.problem.cameras = CameraPair{K, K};
  RigidMotion motion;
  motion.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d(0.2, 1, 0.1).normalized()).toRotationMatrix();
  motion.translation = Eigen::Vector3d(0.4, 0.05, 0.1);
  pair.truth.motion = motion;
  pair.problem.points.resize(kOnPlane + kElsewhere + kWrong, 4);
  for (int i = 0; i < pair.problem.points.rows(); ++i) {
    const double x = rng.Uniform(-1.0, 1.0), y = rng.Uniform(-1.0, 1.0);
    const double depth = i < kOnPlane ? 4.0 + 0.3 * x : rng.Uniform(2.0, 12.0);
    const Eigen::Vector3d point(x, y, depth);
    const Eigen::Vector2d first = Project(K, {}, point);
    Eigen::Vector2d second = Project(K, motion, point);
    if (i >= kOnPlane + kElsewhere) second = Eigen::Vector2d(rng.Uniform(0, 640), rng.Uniform(0, 480));
    pair.problem.points.row(i) << first.transpose(), second.transpose();
  }
  CompleteTruth(pair.problem, &pair.truth);
  return pair;
}

// The pair as a dataset of homographies gives it.
Example Read(const Example& pair, bool dominant_plane) {
  const TemporaryFolder folder;
  CorrespondenceSet set;
  set.pairs = {pair};
  set.cameras = {{"a", {}}, {"b", *pair.truth.motion}};
  WriteCorrespondences(folder / "scene", set);
  CorrespondencesOptions options;
  options.paths = {folder / "scene"};
  options.pairs.task = Task::kHomography;
  options.pairs.dominant_plane = dominant_plane;
  return MakeCorrespondences(options, 1)->Get(0);
}

}  // namespace

TEST_CASE("the dominant plane's homography is the truth of pairs that have a pose alone") {
  const Example pair = PlanePair();
  const auto homography = DominantHomography(pair.problem, pair.truth, 1.0, "a");
  REQUIRE(homography);
  CHECK(*homography == *DominantHomography(pair.problem, pair.truth, 1.0, "a"));
  CHECK(Read(pair, false).truth.model.size() == 0);
  const Example example = Read(pair, true);
  REQUIRE(example.truth.model.size() == 9);
  const auto& inliers = example.truth.inliers;
  CHECK(std::all_of(inliers.begin(), inliers.begin() + kOnPlane, [](auto inlier) { return inlier != 0; }));
  CHECK(std::count(inliers.begin() + kOnPlane, inliers.end(), 1) < 12);
  CHECK(example.truth.pose);
}

TEST_CASE("without a plane that enough matches follow a homography has no truth") {
  Example pair = PlanePair();
  pair.problem.points = PointMatrix(pair.problem.points.bottomRows(kElsewhere + kWrong));
  const auto homography = DominantHomography(pair.problem, pair.truth, 0.05, "a");
  CHECK_FALSE(homography);
  pair.problem.points.conservativeResize(3, 4);
  CHECK_FALSE(DominantHomography(pair.problem, pair.truth, 1.0, "a"));
  CHECK(Read(pair, true).truth.inliers.empty());
}

namespace {

// A pair whose given motion is turned by more than half a degree, some pixels off.
Example RoughPair() {
  Example pair = SyntheticSet(1, 300, Rng(9)).pairs.front();
  pair.scene = "scene";
  pair.truth.assignment.clear();  // inliers are to be judged by the model
  pair.truth.motion->rotation =
      Eigen::AngleAxisd(0.6 * 3.14159 / 180.0, Eigen::Vector3d(1, 2, 3).normalized()) * pair.truth.motion->rotation;
  pair.truth.essential.reset();
  pair.truth.fundamental.reset();
  CompleteTruth(pair.problem, &pair.truth);
  return pair;
}

std::int64_t Near(const Problem& problem, const GroundTruth& truth) {
  return (TruthDistances(problem, truth).array() < 1.0).count();
}

}  // namespace

TEST_CASE("a rough truth is refined on the matches near it, with and without calibration") {
  for (const bool calibrated : {true, false}) {
    Example pair = RoughPair();
    if (!calibrated) pair.problem.cameras.reset();
    const std::int64_t before = Near(pair.problem, pair.truth);
    GroundTruth refined = pair.truth;
    RefineEpipolarTruth(pair.problem, 4.0, &refined);
    CHECK(before < 150);
    CHECK(Near(pair.problem, refined) >= 165);
    CHECK(refined.motion == pair.truth.motion);
    CHECK((refined.essential == pair.truth.essential) == !calibrated);
  }
}

TEST_CASE("a truth is refined with the loss that was asked for, in pixels") {
  for (const double loss_px : {1.0, 2.5, 6.0}) {
    Example pair = RoughPair();
    pair.problem.cameras.reset();
    GroundTruth refined = pair.truth;
    RefineEpipolarTruth(pair.problem, loss_px, &refined);
    const Eigen::VectorXd near = (TruthDistances(pair.problem, pair.truth).array() <= 2.0 * loss_px).cast<double>();
    RefineOptions options;
    options.loss.scale = loss_px;
    Matrix3Parameters expected = AsParameters(*pair.truth.fundamental);
    REQUIRE(RefineFundamental(pair.problem.points, near, options, &expected).status == Status::kOk);
    CAPTURE(loss_px);
    CHECK(AsParameters(*refined.fundamental).isApprox(expected, 1e-9));
  }
}

TEST_CASE("what the matches disagree with a source's pose by") {
  const auto inliers = [](const Example& pair) {
    std::vector<int> rows;
    for (int i = 0; i < 300; ++i)
      if (i % 3 != 0) rows.push_back(i);
    return WithRows(pair, rows);
  };
  const auto disagreement = [](const Example& pair, int near) {
    return TruthDisagreementDegrees(pair.problem, pair.truth, 4.0, near);
  };
  const Example rough = inliers(RoughPair()), sound = inliers(SyntheticSet(1, 300, Rng(9)).pairs.front());
  CHECK(disagreement(rough, 20) > 0.5);
  CHECK(disagreement(rough, 20) < 1.0);
  CHECK(disagreement(sound, 20) < 1e-3);
  CHECK(std::isinf(disagreement(sound, 10000)));
  Example blind = sound;
  blind.problem.cameras.reset();
  CHECK(std::isnan(disagreement(blind, 20)));
}

TEST_CASE("a truth with too few matches near it stays") {
  Example pair = RoughPair();
  pair.problem.points.conservativeResize(12, 4);
  GroundTruth refined = pair.truth;
  RefineEpipolarTruth(pair.problem, 4.0, &refined);
  CHECK(refined.fundamental == pair.truth.fundamental);
}

TEST_CASE("examples for training have the refined inliers and the given pose") {
  Example given = RoughPair(), refined = RoughPair();
  RefineEpipolarTruth(refined.problem, 4.0, &refined.truth);
  for (Example* pair : {&given, &refined}) SetTask(Task::kEssential, 1.0, pair);
  const auto inliers = [](const Example& e) { return std::count(e.truth.inliers.begin(), e.truth.inliers.end(), 1); };
  CHECK(inliers(refined) > inliers(given) + 40);
  CHECK(refined.truth.pose->rotation == given.truth.pose->rotation);
  CHECK(refined.problem.points == given.problem.points);
}

namespace {

// Three planes with exact matches of which the file's labels are 7, 2 and 4, from the largest to the smallest, and
// three outliers that are called a plane of their own, 1.
Example PlanesPair() {
  Example pair = testing::PlanePair({48, 24, 12}, 36, 2, 0.0);
  pair.id = "a-b";
  pair.image1 = "a";
  pair.image2 = "b";
  pair.problem.snn_ratio.resize(0);
  int strays = 0;
  for (std::int32_t& label : pair.truth.assignment) label = label > 0 ? std::vector{7, 2, 4}[label - 1] : strays++ < 3;
  return pair;
}

void Write(const std::string& folder, Example pair) {
  pair.truth.homography.reset();
  CorrespondenceSet set;
  set.pairs = {std::move(pair)};
  WriteCorrespondences(folder, set);
}

std::unique_ptr<Dataset> Read(const std::string& folder, const std::string& more) {
  return MakeDataset(ConfigFromYaml("type: correspondences\npaths: [\"" + folder + "\"]\n" + more, "my.yaml"), 1);
}

constexpr const char* kInstances = "task: homography\nstructures: true\ninlier_threshold_px: 2\n";

double Distance(const Example& example, Eigen::Index i) {
  return Homography::Residual(Matrix3Parameters(example.truth.instances[example.truth.assignment[i] - 1]),
                              example.problem.points.data() + 4 * i);
}

}  // namespace

TEST_CASE("labelled pairs become problems of several structures") {
  const TemporaryFolder folder;
  const Example written = PlanesPair();
  Write(folder / "scene", written);
  const Example read = Read(folder / "scene", kInstances)->Get(0);
  CHECK(read.problem.points == written.problem.points);
  REQUIRE(read.truth.instances.size() == 3);
  for (std::size_t i = 0; i < read.truth.assignment.size(); ++i) {
    const int as_written = written.truth.assignment[i], label = read.truth.assignment[i];
    CHECK(label == (as_written == 7 ? 1 : as_written == 2 ? 2 : as_written == 4 ? 3 : 0));
    CHECK(read.truth.inliers[i] == (label > 0));
    if (label > 0) CHECK(Distance(read, static_cast<Eigen::Index>(i)) < 1e-4);
  }
  for (int k = 0; k < 3; ++k)
    CHECK(std::abs(read.truth.instances[k].dot(written.truth.instances[k])) == Approx(1.0).margin(1e-6));
  CHECK(read.truth.model == read.truth.instances[0]);
  CHECK(AsParameters(*read.truth.homography).isApprox(read.truth.model));
  // Without the key labels stay what the file says.
  const Example plain = Read(folder / "scene", "task: homography\n")->Get(0);
  CHECK(plain.truth.assignment == written.truth.assignment);
  CHECK(plain.truth.instances.empty());
  CHECK(plain.truth.model.size() == 0);
}

TEST_CASE("structures of a pair follow its filter: renumbered by what is left") {
  const TemporaryFolder folder;
  Example pair = PlanesPair();
  // The largest plane has the worst ratios but for three of its matches, and the smallest the best.
  pair.problem.snn_ratio.resize(pair.problem.points.rows());
  int of_largest = 0;
  for (Eigen::Index i = 0; i < pair.problem.snn_ratio.size(); ++i) {
    const int label = pair.truth.assignment[i];
    pair.problem.snn_ratio[i] = label == 7 && of_largest++ >= 3 ? 0.9 : 0.5;
  }
  Write(folder / "scene", pair);
  const Example all = Read(folder / "scene", kInstances)->Get(0);
  const Example part = Read(folder / "scene", std::string(kInstances) + "max_ratio: 0.8\n")->Get(0);
  REQUIRE(part.truth.instances.size() == 2);
  CHECK(part.truth.instances[0] == all.truth.instances[1]);
  CHECK(part.truth.instances[1] == all.truth.instances[2]);
  CHECK(part.truth.model == all.truth.instances[1]);
  const std::vector<int> sizes = InstanceSizes(part);
  CHECK(sizes == std::vector<int>{InstanceSizes(all)[1], InstanceSizes(all)[2]});
  CHECK(CountLabelled(part) == sizes[0] + sizes[1]);
  CHECK(std::count(part.truth.inliers.begin(), part.truth.inliers.end(), 1) == CountLabelled(part));
}

TEST_CASE("a single wrong label hardly moves its plane, and labels without a homography are outliers") {
  Example pair = PlanesPair();
  const auto stray = std::find(pair.truth.assignment.begin(), pair.truth.assignment.end(), 0);
  *stray = 7;
  FitInstances(Task::kHomography, pair.problem, 0.5, &pair.truth);
  REQUIRE(pair.truth.instances.size() == 3);
  std::vector<double> distances;
  for (std::size_t i = 0; i < pair.truth.assignment.size(); ++i)
    if (pair.truth.assignment[i] == 1) distances.push_back(Distance(pair, static_cast<Eigen::Index>(i)));
  std::nth_element(distances.begin(), distances.begin() + distances.size() / 2, distances.end());
  CHECK(distances[distances.size() / 2] < 1.0);

  Example line = PlanesPair();
  for (Eigen::Index i = 0; i < line.problem.points.rows(); ++i)
    if (line.truth.assignment[i] == 7) line.problem.points.row(i) << 3.0 * i, 2.0 * i, 3.0 * i + 5.0, 2.0 * i;
  FitInstances(Task::kHomography, line.problem, 2.0, &line.truth);
  CHECK(line.truth.instances.size() == 2);
  Example none = PlanesPair();
  std::fill(none.truth.assignment.begin(), none.truth.assignment.end(), 0);
  FitInstances(Task::kHomography, none.problem, 2.0, &none.truth);
  CHECK(none.truth.instances.empty());
  CHECK(none.truth.model.size() == 0);
  CHECK(!none.truth.homography);
}

TEST_CASE("labelled motions become several fundamental matrices, of too few matches none") {
  // Two rigid motions of general points, the second turned further, and seven matches of a third.
  Rng rng(4);
  Example pair;
  pair.id = "a-b";
  pair.image1 = "a";
  pair.image2 = "b";
  pair.problem.size1 = pair.problem.size2 = {640, 480};
  pair.problem.points.resize(107, 4);
  for (int i = 0; i < 107; ++i) {
    const int motion = i < 60 ? 1 : i < 100 ? 2 : 3;
    pair.truth.assignment.push_back(motion);
    const Eigen::Vector3d here(rng.Uniform(-1.0, 1.0), rng.Uniform(-1.0, 1.0), rng.Uniform(4.0, 7.0));
    const Eigen::AngleAxisd turn(0.05 * motion, Eigen::Vector3d(0.2, 1.0, 0.1 * motion).normalized());
    const Eigen::Vector3d there = turn * here + Eigen::Vector3d(0.4, 0.3 - 0.2 * motion, 0.1);
    pair.problem.points.row(i) << 500.0 * here.head<2>().transpose() / here.z() + Eigen::RowVector2d(320.0, 240.0),
        500.0 * there.head<2>().transpose() / there.z() + Eigen::RowVector2d(320.0, 240.0);
  }
  const TemporaryFolder folder;
  Write(folder / "scene", pair);
  const Example read = Read(folder / "scene", "task: fundamental\nstructures: true\ninlier_threshold_px: 2\n")->Get(0);
  REQUIRE(read.truth.instances.size() == 2);
  for (int i = 0; i < 107; ++i) {
    const int label = read.truth.assignment[i];
    CHECK(label == (i < 60 ? 1 : i < 100 ? 2 : 0));
    if (label == 0) continue;
    const Matrix3Parameters model = read.truth.instances[label - 1];
    CHECK(Fundamental::Residual(model, pair.problem.points.data() + 4 * i) < 1e-4);
  }
  CHECK(AsParameters(*read.truth.fundamental).isApprox(read.truth.model));
}

TEST_CASE("structures of pairs: mistakes are named") {
  const TemporaryFolder folder;
  Example pair = PlanesPair();
  Write(folder / "labelled", pair);
  pair.truth.assignment.clear();
  Write(folder / "bare", pair);
  const auto error = [&](const std::string& scene, const std::string& more) {
    return ErrorOf([&] { Read(folder / scene, more)->Get(0); });
  };
  CHECK(Has(error("bare", kInstances), "a-b: no labels (labels.h5)"));
  CHECK(Has(error("labelled", "task: shared_focal\nstructures: true\n"), "task: homography or fundamental"));
  CHECK(Has(error("labelled", std::string(kInstances) + "dominant_plane: true\n"), "dominant_plane"));
}

}  // namespace diffsac
