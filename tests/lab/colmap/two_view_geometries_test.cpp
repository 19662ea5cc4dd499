#include "lab/colmap/two_view_geometries.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cstring>

#include "core/errors.h"
#include "lab/colmap/colmap_test_util.h"
#include "lab/colmap/lens.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {
namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr int kPoints = 40;

// Two cameras that see the same points, as COLMAP would store them.
struct TwoViews {
  ColmapCamera camera1{2, {640, 480}, {500, 320, 240, -0.1}, true};
  ColmapCamera camera2{1, {800, 600}, {610, 600, 390, 310}, true};
  RigidMotion motion{Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.1, 1.0, -0.2).normalized()).toRotationMatrix(),
                     {0.6, -0.64, 0.48}};
  PointMatrix seen1 = PointMatrix(kPoints, 2), seen2 = PointMatrix(kPoints, 2);  // COLMAP's pixels

  TwoViews() {
    const ColmapLens lens1(camera1, ""), lens2(camera2, "");
    for (int i = 0; i < kPoints; ++i) {
      const Eigen::Vector3d point(0.3 * (i % 7) - 1.0, 0.25 * (i % 5) - 0.5, 4.0 + 0.1 * (i % 11));
      const auto see = [](const ColmapLens& lens, const Eigen::Vector3d& p) {
        return Eigen::RowVector2d((lens.Distort((lens.K() * p).hnormalized()).array() + 0.5).transpose());
      };
      seen1.row(i) = see(lens1, point);
      seen2.row(kPoints - 1 - i) = see(lens2, motion.rotation * point + motion.translation);
    }
  }

  void Fill(DatabaseMaker* maker) const {
    maker->AddCamera(1, camera1.model, camera1.parameters, true, camera1.size);
    maker->AddCamera(2, camera2.model, camera2.parameters, true, camera2.size);
    maker->AddImage(1, "one.jpg", 1);
    maker->AddImage(2, "two.jpg", 2);
    maker->AddKeypoints(1, seen1);
    maker->AddKeypoints(2, seen2);
    maker->AddMatches({1, 2}, Crossed(kPoints));
  }

  ColmapGeometry Geometry() const {
    ColmapGeometry geometry;
    geometry.pair = {1, 2};
    geometry.configuration = ColmapConfiguration::kCalibrated;
    geometry.inliers = Crossed(kPoints).topRows(30);
    geometry.essential = EssentialFromMotion(motion);
    const ColmapLens lens1(camera1, ""), lens2(camera2, "");
    geometry.fundamental =
        FundamentalInColmapPixels(lens2.K().inverse().transpose() * geometry.essential * lens1.K().inverse());
    geometry.motion = motion;
    return geometry;
  }
};

// A row as COLMAP reads it.
struct Row {
  std::int64_t count = 0, columns = 0, configuration = 0;
  MatchIndices inliers;
  Eigen::Matrix3d F, E, H;
  Eigen::Vector4d qvec;
  Eigen::Vector3d tvec;
};

template <class Matrix>
Matrix MatrixFrom(std::span<const std::byte> bytes) {
  Matrix matrix;
  REQUIRE(bytes.size() == sizeof(double) * matrix.size());
  std::memcpy(matrix.data(), bytes.data(), bytes.size());
  return matrix;
}

Row ReadRow(const std::string& path, const ColmapPair& pair) {
  const SqliteDatabase database(path, SqliteDatabase::Access::kRead);
  SqliteStatement statement(database,
                            "SELECT rows, cols, data, config, F, E, H, qvec, tvec FROM two_view_geometries "
                            "WHERE pair_id = ?");
  statement.Bind(1, PairId(pair));
  Row row;
  if (!statement.Step()) return row;
  row.count = statement.Integer(0);
  row.columns = statement.Integer(1);
  REQUIRE(statement.Blob(2).size() == 8 * static_cast<std::size_t>(row.count));
  row.inliers.resize(row.count, 2);
  if (row.count > 0) std::memcpy(row.inliers.data(), statement.Blob(2).data(), statement.Blob(2).size());
  row.configuration = statement.Integer(3);
  row.F = MatrixFrom<RowMajor3>(statement.Blob(4));
  row.E = MatrixFrom<RowMajor3>(statement.Blob(5));
  row.H = MatrixFrom<RowMajor3>(statement.Blob(6));
  row.qvec = MatrixFrom<Eigen::Vector4d>(statement.Blob(7));
  row.tvec = MatrixFrom<Eigen::Vector3d>(statement.Blob(8));
  return row;
}

// The largest distance of an inlier to its epipolar line in image 2, in the coordinates that `place1` and `place2` give
// it.
template <class Place1, class Place2>
double LargestResidual(const Row& row, const Eigen::Matrix3d& F, const TwoViews& views, Place1 place1, Place2 place2) {
  double largest = 0.0;
  for (Eigen::Index i = 0; i < row.count; ++i) {
    const Eigen::Vector2d x1 = place1(views.seen1.row(row.inliers(i, 0)).transpose());
    const Eigen::Vector2d x2 = place2(views.seen2.row(row.inliers(i, 1)).transpose());
    largest = std::max(largest,
                       std::abs(x2.homogeneous().dot(F * x1.homogeneous())) / (F * x1.homogeneous()).head<2>().norm());
  }
  return largest;
}

Eigen::Vector2d Straight(const ColmapCamera& camera, const Eigen::Vector2d& colmap) {
  return ColmapLens(camera, "").Undistort(colmap.array() - 0.5)->array() + 0.5;
}

}  // namespace

TEST_CASE("two-view geometries: what COLMAP reads holds for the keypoints that it has") {
  TemporaryFolder folder;
  const TwoViews views;
  DatabaseMaker maker(folder / "d.db");
  views.Fill(&maker);
  const ColmapDatabase database(folder / "d.db", SqliteDatabase::Access::kWrite);
  // As named by the pair, or with the images the other way round.
  for (const bool exchanged : {false, true}) {
    const ColmapGeometry geometry = views.Geometry();
    WriteGeometries(database, {exchanged ? Exchanged(geometry) : geometry}, exchanged);
    const Row row = ReadRow(folder / "d.db", {1, 2});
    CHECK(row.count == 30);
    CHECK(row.columns == 2);
    CHECK(row.configuration == 2);
    CHECK(row.inliers == geometry.inliers);
    const auto straight1 = [&](const Eigen::Vector2d& x) { return Straight(views.camera1, x); };
    const auto straight2 = [&](const Eigen::Vector2d& x) { return Straight(views.camera2, x); };
    CHECK(LargestResidual(row, row.F, views, straight1, straight2) < 1e-3);
    // Half a pixel matters.
    const auto shifted = [&](const Eigen::Vector2d& x) { return Eigen::Vector2d(straight1(x).array() - 0.5); };
    CHECK(LargestResidual(row, row.F, views, shifted, straight2) > 0.05);
    const auto normalized1 = [&](const Eigen::Vector2d& x) {
      const auto& p = views.camera1.parameters;
      return Eigen::Vector2d((straight1(x) - Eigen::Vector2d(p[1], p[2])) / p[0]);
    };
    const auto normalized2 = [&](const Eigen::Vector2d& x) {
      const auto& p = views.camera2.parameters;
      return Eigen::Vector2d((x.x() - p[2]) / p[0], (x.y() - p[3]) / p[1]);
    };
    CHECK(LargestResidual(row, row.E, views, normalized1, normalized2) < 1e-6);
    CHECK(row.H.isZero(0.0));
    const Eigen::Quaterniond q(row.qvec[0], row.qvec[1], row.qvec[2], row.qvec[3]);
    CHECK(q.norm() == Approx(1.0));
    CHECK(q.toRotationMatrix().isApprox(views.motion.rotation, 1e-9));
    CHECK(row.tvec.isApprox(views.motion.translation, 1e-9));
  }
}

TEST_CASE("two-view geometries: homographies in COLMAP's pixels, and exchanged") {
  Eigen::Matrix3d H;
  H << 1.1, 0.1, 20, -0.05, 0.9, 7, 1e-4, -2e-4, 1;
  const Eigen::Vector2d ours1(100, 50), ours2 = (H * ours1.homogeneous()).hnormalized();
  const Eigen::Vector2d half(0.5, 0.5);
  const Eigen::Matrix3d colmap = HomographyInColmapPixels(H);
  CHECK((colmap * (ours1 + half).homogeneous()).hnormalized().isApprox(ours2 + half, 1e-12));
  ColmapGeometry geometry;
  geometry.pair = {7, 3};
  geometry.homography = colmap;
  geometry.inliers = Crossed(4);
  const ColmapGeometry other = Exchanged(geometry);
  CHECK(other.pair == ColmapPair{3, 7});
  CHECK((other.homography * (ours2 + half).homogeneous()).hnormalized().isApprox(ours1 + half, 1e-9));
  CHECK(other.inliers(0, 0) == 3);
  CHECK(other.inliers(0, 1) == 0);
}

TEST_CASE("two-view geometries: pairs that fail, or have too few inliers, are degenerate") {
  TemporaryFolder folder;
  const TwoViews views;
  DatabaseMaker maker(folder / "d.db");
  views.Fill(&maker);
  const ColmapDatabase database(folder / "d.db", SqliteDatabase::Access::kWrite);
  ColmapGeometry few = views.Geometry(), failed;
  few.inliers.conservativeResize(14, 2);
  failed.pair = {1, 2};
  for (const ColmapGeometry& geometry : {few, failed}) {
    WriteGeometries(database, {geometry}, true);
    const Row row = ReadRow(folder / "d.db", {1, 2});
    CHECK(row.count == 0);
    CHECK(row.columns == 2);
    CHECK(row.configuration == 1);
    CHECK(row.F.isZero(0.0));
    CHECK(row.qvec.isZero(0.0));
  }
}

TEST_CASE("two-view geometries: all or none, and nothing in place of others") {
  TemporaryFolder folder;
  const TwoViews views;
  DatabaseMaker maker(folder / "d.db");
  views.Fill(&maker);
  maker.AddImage(3, "three.jpg");
  maker.AddKeypoints(3, views.seen1);
  const ColmapDatabase database(folder / "d.db", SqliteDatabase::Access::kWrite);
  const auto error = [&](const std::vector<ColmapGeometry>& geometries, bool overwrite = false) {
    return ErrorOf([&] { WriteGeometries(database, geometries, overwrite); });
  };
  ColmapGeometry good = views.Geometry(), bad = good;
  good.pair = {1, 3};
  bad.inliers(3, 1) = kPoints;
  CHECK(Has(error({good, bad}), "d.db: image 'one.jpg' and image 'two.jpg': an inlier is none of the 40 keypoints"));
  CHECK(ReadRow(folder / "d.db", {1, 3}).columns == 0);
  bad = views.Geometry();
  bad.inliers(3, 1) = 0;
  CHECK(Has(error({bad}), "an inlier is none of its matches"));
  // Pairs without matches in the database: any keypoints will do.
  CHECK(error({good}) == "");
  CHECK(Has(error({views.Geometry(), good}),
            "d.db: 1 of the 2 pairs have a two-view geometry already; --export-overwrite replaces them"));
  CHECK(ReadRow(folder / "d.db", {1, 2}).columns == 0);
  CHECK(error({views.Geometry(), good}, true) == "");
  CHECK(ReadRow(folder / "d.db", {1, 2}).count == 30);
  maker.Run("BEGIN EXCLUSIVE");
  CHECK(Has(error({views.Geometry()}, true), "d.db: locked by another program"));
  maker.Run("ROLLBACK");
  CHECK(ReadRow(folder / "d.db", {1, 2}).count == 30);
}

}  // namespace diffsac
