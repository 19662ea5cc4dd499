#include "lab/eval/export_colmap.h"

#include <catch2/catch.hpp>

#include <cstring>
#include <filesystem>
#include <set>
#include <sstream>

#include "core/temporary_folder.h"
#include "diffsac/geometry/epipolar.h"
#include "lab/colmap/colmap_test_util.h"
#include "lab/colmap/two_view_geometries.h"
#include "lab/data/two_view_test_util.h"
#include "lab/eval/evaluate.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

constexpr int kPoints = 60;

// A database of three images and the pairs of it as they are prepared: every third match is wrong, match i joins
// keypoints i and kPoints - 1 - i.
struct ColmapProject {
  TemporaryFolder folder;
  CorrespondenceSet set = SyntheticSet(2, kPoints, Rng(3));
  std::unique_ptr<DatabaseMaker> maker;

  ColmapProject() {
    maker = std::make_unique<DatabaseMaker>(folder / "d.db");
    maker->AddCamera(1, 0, {500, 320, 240});
    for (int i = 0; i < 3; ++i) {
      maker->AddImage(i + 1, "im-00" + std::to_string(i) + ".jpg");
      maker->AddKeypoints(i + 1, PointMatrix::Ones(kPoints, 2));
    }
    Rng rng(5);
    for (Example& pair : set.pairs)
      for (int k = 0; k < kPoints; k += 3)
        pair.problem.points.row(k).tail<2>() << rng.Uniform(0, 600), rng.Uniform(0, 400);
    for (int i = 0; i < 2; ++i) {
      maker->AddMatches({i + 1, i + 2}, Crossed(kPoints));
      set.match_indices.push_back(Crossed(kPoints));
    }
    Prepare();
    WriteFileAtomically(folder / "e.yaml", R"(
name: verified
task: fundamental
metric: {threshold_deg: 10}
data: {type: correspondences, paths: [)" + (folder / "scene") +
                                               R"(], task: "${task}", inlier_threshold_px: 1}
methods: [{name: lo, type: lo_ransac, max_iterations: 200}, {name: plain, type: ransac, max_iterations: 200}]
)");
  }

  void Prepare() { WriteCorrespondences(folder / "scene", set); }

  EvalRequest Request(const std::vector<std::string>& assignments = {}) const {
    EvalRequest request;
    request.config_path = folder / "e.yaml";
    request.output = folder / "run";
    request.methods = {"lo"};
    request.assignments = assignments;
    request.colmap.database = folder / "d.db";
    return request;
  }

  std::string Run(const EvalRequest& request) const {
    const std::atomic<bool> stop{false};
    std::ostringstream out;
    try {
      Evaluate(request, {}, stop, out);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  // Inliers and configuration of a pair; -1 where it has no row.
  std::pair<MatchIndices, int> Row(const ColmapPair& pair) const {
    const SqliteDatabase database(folder / "d.db", SqliteDatabase::Access::kRead);
    SqliteStatement statement(database, "SELECT rows, data, config FROM two_view_geometries WHERE pair_id = ?");
    statement.Bind(1, PairId(pair));
    if (!statement.Step()) return {MatchIndices(0, 2), -1};
    MatchIndices inliers(statement.Integer(0), 2);
    if (inliers.rows() > 0) std::memcpy(inliers.data(), statement.Blob(1).data(), statement.Blob(1).size());
    return {inliers, static_cast<int>(statement.Integer(2))};
  }
};

bool Has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Whether all inliers but `wrong` of them are matches that are right, and most of those are there.
bool AreRight(const MatchIndices& inliers, int least, int wrong) {
  int bad = 0;
  for (Eigen::Index i = 0; i < inliers.rows(); ++i)
    bad += inliers(i, 1) != kPoints - 1 - inliers(i, 0) || inliers(i, 0) % 3 == 0 ? 1 : 0;
  return inliers.rows() >= least && bad <= wrong;
}

}  // namespace

TEST_CASE("export to COLMAP: the inliers of a run as keypoints, for every task") {
  const std::pair<const char*, int> tasks[] = {{"essential", 2}, {"fundamental", 3}, {"shared_focal", 3}};
  for (const auto& [task, configuration] : tasks) {
    ColmapProject project;
    REQUIRE(project.Run(project.Request({std::string("task=") + task})) == "");
    for (const ColmapPair& pair : {ColmapPair{1, 2}, ColmapPair{2, 3}}) {
      const auto [inliers, found] = project.Row(pair);
      INFO(task << ": " << inliers.rows() << " inliers");
      CHECK(found == configuration);
      CHECK(AreRight(inliers, 38, 3));
    }
  }
}

// A pure rotation was written as a calibrated pair, whose baseline COLMAP would have believed.
TEST_CASE("export to COLMAP: a turn is panoramic, an image with itself a watermark, F of either has a homography") {
  struct Case {
    const char* task;
    double degrees;
    int configuration;
  };
  for (const Case& c :
       {Case{"essential", 10.0, 5}, {"essential", 0.0, 7}, {"fundamental", 10.0, 5}, {"fundamental", 0.0, 7}}) {
    ColmapProject project;
    for (Example& pair : project.set.pairs) {
      const Eigen::Matrix3d& K = pair.problem.cameras->K1;
      pair.problem.cameras->K2 = K;
      const Eigen::Matrix3d turn =
          K * Eigen::AngleAxisd(c.degrees * 0.0174533, Eigen::Vector3d::UnitY()).toRotationMatrix() * K.inverse();
      for (int i = 0; i < kPoints; ++i)
        if (i % 3 != 0)
          pair.problem.points.row(i).tail<2>() =
              (turn * pair.problem.points.row(i).head<2>().transpose().homogeneous()).hnormalized().transpose();
    }
    project.Prepare();
    REQUIRE(project.Run(project.Request({std::string("task=") + c.task})) == "");
    CAPTURE(c.task, c.degrees);
    CHECK(project.Row({1, 2}).second == c.configuration);
    const SqliteDatabase database(project.folder / "d.db", SqliteDatabase::Access::kRead);
    SqliteStatement statement(database, "SELECT H, tvec FROM two_view_geometries WHERE pair_id = ?");
    statement.Bind(1, PairId({1, 2}));
    REQUIRE(statement.Step());
    Matrix3Parameters h;
    Eigen::Vector3d t;
    REQUIRE(statement.Blob(0).size() == sizeof(h));
    std::memcpy(h.data(), statement.Blob(0).data(), sizeof(h));
    std::memcpy(t.data(), statement.Blob(1).data(), sizeof(t));
    CHECK(t.isZero(0.0));
    const PointMatrix points = project.set.pairs[0].problem.points.array() + 0.5;
    for (int i = 1; i < kPoints; i += 3)
      CHECK((AsMatrix(h) * points.row(i).head<2>().transpose().homogeneous())
                .hnormalized()
                .isApprox(points.row(i).tail<2>().transpose(), 1e-2));
  }
}

TEST_CASE("export to COLMAP: F of a focal length that was found holds in COLMAP's pixels") {
  ColmapProject project;
  REQUIRE(project.Run(project.Request({"task=shared_focal"})) == "");
  const SqliteDatabase database(project.folder / "d.db", SqliteDatabase::Access::kRead);
  SqliteStatement statement(database, "SELECT F FROM two_view_geometries WHERE pair_id = ?");
  statement.Bind(1, PairId({1, 2}));
  REQUIRE(statement.Step());
  Matrix3Parameters f;
  REQUIRE(statement.Blob(0).size() == sizeof(f));
  std::memcpy(f.data(), statement.Blob(0).data(), sizeof(f));
  const PointMatrix points = project.set.pairs[0].problem.points.array() + 0.5;
  int right = 0;
  for (int i = 0; i < kPoints; ++i)
    if (i % 3 != 0) right += SampsonError(f, points.row(i).data()) < 1.0 ? 1 : 0;
  CHECK(right >= 36);
}

TEST_CASE("export to COLMAP: a filter leaves matches out and in another order, keypoints stay the same") {
  ColmapProject project;
  EvalRequest request = project.Request({"data.max_ratio=0.9", "data.shuffle_points=true", "data.max_points=50"});
  REQUIRE(project.Run(request) == "");
  const auto [inliers, configuration] = project.Row({1, 2});
  CHECK(configuration == 3);
  CHECK(AreRight(inliers, 25, 3));
  CHECK(inliers.rows() < 40);
}

TEST_CASE("export to COLMAP: images the other way round, a pair without matches") {
  ColmapProject project;
  Example& pair = project.set.pairs[1];
  std::swap(pair.image1, pair.image2);
  pair.id = pair.image1 + "-" + pair.image2;
  const PointMatrix points = pair.problem.points;
  pair.problem.points << points.rightCols(2), points.leftCols(2);
  project.set.match_indices[1].col(0).swap(project.set.match_indices[1].col(1));
  Example& empty = project.set.pairs[0];
  empty.problem.points.resize(0, 4);
  empty.problem.snn_ratio.resize(0);
  empty.problem.scale_rotation_changes.resize(0, 2);
  empty.problem.descriptors.resize(0, 0);
  empty.truth.assignment.clear();
  project.set.match_indices[0].resize(0, 2);
  project.Prepare();
  REQUIRE(project.Run(project.Request()) == "");
  const auto [inliers, configuration] = project.Row({2, 3});
  CHECK(configuration == 3);
  CHECK(AreRight(inliers, 38, 3));
  CHECK(project.Row({1, 2}).second == 1);
  CHECK(project.Row({1, 2}).first.rows() == 0);
}

TEST_CASE("export to COLMAP: a pair that shares nothing was verified with status ok") {
  ColmapProject project;
  Rng rng(11);
  PointMatrix& points = project.set.pairs[1].problem.points;
  for (int i = 0; i < kPoints; ++i)
    points.row(i) << rng.Uniform(0, 640), rng.Uniform(0, 480), rng.Uniform(0, 640), rng.Uniform(0, 480);
  project.Prepare();
  // Wide enough that COLMAP's 15 inliers are found in matches that are all wrong.
  EvalRequest request = project.Request({"data.inlier_threshold_px=20"});
  REQUIRE(project.Run(request) == "");
  // Within 20 pixels a rotation explains it as well as F does.
  CHECK(project.Row({1, 2}).second != 1);
  CHECK(project.Row({2, 3}).second == 1);
  CHECK(project.Row({2, 3}).first.rows() == 0);
  request.colmap.chance = true;
  request.colmap.overwrite = true;
  REQUIRE(project.Run(request) == "");
  CHECK(project.Row({2, 3}).second == 3);
  CHECK(project.Row({2, 3}).first.rows() >= kColmapMinInliers);
}

TEST_CASE("export to COLMAP: what cannot be exported is said before the work") {
  const ColmapProject project;
  const auto error = [&](EvalRequest request) {
    const std::string message = project.Run(request);
    CHECK_FALSE(std::filesystem::exists(project.folder / "run/problems.csv"));
    return message;
  };
  EvalRequest request = project.Request();
  request.methods.clear();
  CHECK(Has(error(request), "estimates of one row; choose it with --methods: lo, plain"));
  const std::string two = "conditions=[{name: all}, {name: few, data: {max_ratio: 0.5}}]";
  CHECK(Has(error(project.Request({two})), "one condition, but the experiment has all, few"));
  CHECK(Has(error(project.Request({"estimates=false"})), "needs estimates: true"));
  CHECK(Has(error(project.Request({"data={type: synthetic_two_view, task: fundamental}"})),
            "needs data of type correspondences, not synthetic_two_view"));
  CHECK(Has(error(project.Request({"seeds=[1, 2]"})), "of several seeds choose one"));
  request = project.Request();
  request.colmap.database = project.folder / "other.db";
  CHECK(Has(error(request), "other.db: no such file"));
  WriteFileAtomically(project.folder / "other.db", "");
  CHECK(Has(error(request), "no table 'cameras'"));
}

TEST_CASE("export to COLMAP: where it fails the run is complete and the database as it was") {
  ColmapProject project;
  project.maker->Run("INSERT INTO two_view_geometries(pair_id, rows, cols, config) VALUES(" +
                     std::to_string(PairId({2, 3})) + ", 0, 2, 7)");
  EvalRequest request = project.Request();
  CHECK(Has(project.Run(request), "1 of the 2 pairs have a two-view geometry already; --export-overwrite"));
  CHECK(std::filesystem::exists(project.folder / "run/estimates.h5"));
  CHECK(std::filesystem::exists(project.folder / "run/run.json"));
  CHECK(project.Row({1, 2}).second == -1);
  CHECK(project.Row({2, 3}).second == 7);
  request.colmap.overwrite = true;
  CHECK(project.Run(request) == "");
  CHECK(project.Row({2, 3}).second == 3);
  project.maker->Run("DELETE FROM images WHERE image_id = 3");
  CHECK(Has(project.Run(request), "d.db: it has no image 'im_002' of the pair scene/im_001-im_002"));
  project.set.match_indices.clear();
  project.Prepare();
  CHECK(Has(project.Run(request), "match_indices.h5: no such file"));
}

}  // namespace diffsac
