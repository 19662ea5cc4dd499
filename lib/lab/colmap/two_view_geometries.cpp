#include "lab/colmap/two_view_geometries.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "diffsac/core/status.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {
namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// COLMAP's pixels to ours.
Eigen::Matrix3d ToOurs() {
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift(0, 2) = shift(1, 2) = -0.5;
  return shift;
}

void CheckInliers(const ColmapDatabase& database, const ColmapGeometry& geometry) {
  const ColmapPair& pair = geometry.pair;
  const std::string place =
      database.path() + ": " + database.NameOf(pair.image1) + " and " + database.NameOf(pair.image2) + ": ";
  for (int side = 0; side < 2; ++side) {
    const std::int64_t image = side == 0 ? pair.image1 : pair.image2, count = database.KeypointCount(image);
    const auto column = geometry.inliers.col(side);
    if (column.minCoeff() < 0 || column.maxCoeff() >= count)
      throw Error(place + "an inlier is none of the " + std::to_string(count) + " keypoints of " +
                  database.NameOf(image) + ": the database has changed, or is another one");
  }
  const MatchIndices matches = database.Matches(pair);
  if (matches.rows() == 0) return;
  std::set<std::pair<int, int>> known;
  for (Eigen::Index i = 0; i < matches.rows(); ++i) known.emplace(matches(i, 0), matches(i, 1));
  for (Eigen::Index i = 0; i < geometry.inliers.rows(); ++i)
    if (known.count({geometry.inliers(i, 0), geometry.inliers(i, 1)}) == 0)
      throw Error(place + "an inlier is none of its matches: the database has changed, or is another one");
}

void CheckNew(const ColmapDatabase& database, const std::vector<ColmapGeometry>& geometries) {
  SqliteStatement statement(database.sqlite(), "SELECT 1 FROM two_view_geometries WHERE pair_id = ?");
  std::size_t count = 0;
  for (const ColmapGeometry& geometry : geometries) {
    statement.Bind(1, PairId(geometry.pair));
    count += statement.Step() ? 1 : 0;
    statement.Reset();
  }
  if (count > 0)
    throw Error(database.path() + ": " + std::to_string(count) + " of the " + std::to_string(geometries.size()) +
                " pairs have a two-view geometry already; --export-overwrite replaces them");
}

void Write(SqliteStatement* statement, const ColmapGeometry& geometry) {
  const Eigen::Matrix<std::uint32_t, Eigen::Dynamic, 2, Eigen::RowMajor> inliers =
      geometry.inliers.cast<std::uint32_t>();
  Eigen::Vector4d rotation = Eigen::Vector4d::Zero();  // w x y z
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  if (geometry.motion) {
    const Eigen::Quaterniond q(geometry.motion->rotation);
    rotation << q.w(), q.x(), q.y(), q.z();
    if (q.w() < 0.0) rotation = -rotation;
    translation = geometry.motion->translation;
  }
  const RowMajor3 F = geometry.fundamental, E = geometry.essential, H = geometry.homography;
  statement->Run(PairId(geometry.pair), std::int64_t{inliers.rows()}, std::int64_t{2}, BytesOf(inliers),
                 static_cast<std::int64_t>(geometry.configuration), BytesOf(F), BytesOf(E), BytesOf(H),
                 BytesOf(rotation), BytesOf(translation));
}

/// Of epipolar geometry that the matches leave open: what they show is a homography, fitted to them here by the sum of
/// distances, in pixels, which a few wrong inliers do not spoil.
void SetUndetermined(const FoundGeometry& found, ColmapGeometry* geometry) {
  if (found.degeneracy == Degeneracy::kLine) return;
  geometry->configuration = found.degeneracy == Degeneracy::kPureRotation ? ColmapConfiguration::kPanoramic
                            : found.degeneracy == Degeneracy::kStatic     ? ColmapConfiguration::kWatermark
                                                                          : ColmapConfiguration::kPlanarOrPanoramic;
  constexpr int kRounds = 20;
  constexpr double kExact = 0.1;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(found.points.rows());
  for (const std::int32_t row : found.inliers) weights[row] = 1.0;
  Matrix3Parameters homography;
  bool fitted = false;
  for (int round = 0; round < kRounds && Homography::Fit(found.points, weights, &homography); ++round) {
    fitted = true;
    for (const std::int32_t row : found.inliers)
      weights[row] = 1.0 / (kExact + SymmetricTransferError(homography, found.points.row(row).data()));
  }
  if (fitted) geometry->homography = HomographyInColmapPixels(AsMatrix(homography));
}

}  // namespace

ColmapGeometry GeometryOf(const FoundGeometry& found) {
  ColmapGeometry geometry;
  geometry.motion = found.motion;
  if (IsUndetermined(found.degeneracy)) {
    SetUndetermined(found, &geometry);
  } else if (found.homography) {
    geometry.configuration = ColmapConfiguration::kPlanarOrPanoramic;
    geometry.homography = HomographyInColmapPixels(*found.homography);
  } else {
    geometry.configuration = found.essential ? ColmapConfiguration::kCalibrated : ColmapConfiguration::kUncalibrated;
    geometry.fundamental = FundamentalInColmapPixels(found.fundamental);
    if (found.essential) geometry.essential = *found.essential;
  }
  return geometry;
}

Eigen::Matrix3d FundamentalInColmapPixels(const Eigen::Matrix3d& fundamental) {
  return ToOurs().transpose() * fundamental * ToOurs();
}

Eigen::Matrix3d HomographyInColmapPixels(const Eigen::Matrix3d& homography) {
  return ToOurs().inverse() * homography * ToOurs();
}

ColmapGeometry Exchanged(const ColmapGeometry& geometry) {
  ColmapGeometry exchanged = geometry;
  std::swap(exchanged.pair.image1, exchanged.pair.image2);
  exchanged.inliers.col(0).swap(exchanged.inliers.col(1));
  exchanged.fundamental.transposeInPlace();
  exchanged.essential.transposeInPlace();
  if (!geometry.homography.isZero(0.0)) exchanged.homography = geometry.homography.inverse();
  if (geometry.motion) exchanged.motion = Inverse(*geometry.motion);
  return exchanged;
}

void WriteGeometries(const ColmapDatabase& database, const std::vector<ColmapGeometry>& geometries, bool overwrite) {
  std::vector<ColmapGeometry> rows;
  for (const ColmapGeometry& geometry : geometries) {
    rows.push_back(geometry.pair.image1 < geometry.pair.image2 ? geometry : Exchanged(geometry));
    ColmapGeometry& row = rows.back();
    const bool verified =
        row.configuration != ColmapConfiguration::kDegenerate && row.inliers.rows() >= kColmapMinInliers;
    if (verified) {
      CheckInliers(database, row);
    } else {
      const ColmapPair pair = row.pair;
      row = ColmapGeometry();
      row.pair = pair;
    }
  }
  SqliteTransaction transaction(database.sqlite());
  if (!overwrite) CheckNew(database, rows);
  SqliteStatement statement(database.sqlite(),
                            "INSERT OR REPLACE INTO two_view_geometries(pair_id, rows, cols, data, config, F, E, H, "
                            "qvec, tvec) VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  for (const ColmapGeometry& row : rows) Write(&statement, row);
  transaction.Commit();
}

}  // namespace diffsac
