#include "lab/colmap/create.h"

#include <cmath>

#include "diffsac/core/status.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

// The tables of COLMAP 3.8; its own programs add what later versions have.
constexpr const char* kSchema = R"(
PRAGMA journal_mode = MEMORY;
PRAGMA user_version = 3800;
CREATE TABLE cameras(camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, model INTEGER NOT NULL,
  width INTEGER NOT NULL, height INTEGER NOT NULL, params BLOB, prior_focal_length INTEGER NOT NULL);
CREATE TABLE images(image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, name TEXT NOT NULL UNIQUE,
  camera_id INTEGER NOT NULL, prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL,
  prior_tx REAL, prior_ty REAL, prior_tz REAL,
  CONSTRAINT image_id_check CHECK(image_id >= 0 and image_id < 2147483647),
  FOREIGN KEY(camera_id) REFERENCES cameras(camera_id));
CREATE UNIQUE INDEX index_name ON images(name);
CREATE TABLE keypoints(image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB,
  FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE descriptors(image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL,
  data BLOB, FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE matches(pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB);
CREATE TABLE two_view_geometries(pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL,
  data BLOB, config INTEGER NOT NULL, F BLOB, E BLOB, H BLOB, qvec BLOB, tvec BLOB);
)";

void AddCameras(const SqliteDatabase& database, const std::vector<ColmapCamera>& cameras) {
  SqliteStatement insert(database,
                         "INSERT INTO cameras(camera_id, model, width, height, params, prior_focal_length) "
                         "VALUES(?, ?, ?, ?, ?, ?)");
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const ColmapCamera& camera = cameras[i];
    insert.Run(static_cast<std::int64_t>(i) + 1, std::int64_t{camera.model}, std::int64_t{camera.size.width},
               std::int64_t{camera.size.height}, BytesOf(camera.parameters),
               std::int64_t{camera.has_prior_focal_length});
  }
}

// x, y, scale and orientation, as COLMAP's programs read them beside the affine shapes of six columns.
void AddKeypoints(const SqliteDatabase& database, std::int64_t id, const NewColmapImage& image) {
  Eigen::Matrix<float, Eigen::Dynamic, 4, Eigen::RowMajor> rows(image.keypoints.rows(), 4);
  rows.leftCols<2>() = image.keypoints.cast<float>();
  rows.col(2) = image.frames.col(0).array().exp().matrix().cast<float>();
  rows.col(3) = image.frames.col(1).cast<float>();
  SqliteStatement insert(database, "INSERT INTO keypoints(image_id, rows, cols, data) VALUES(?, ?, 4, ?)");
  insert.Run(id, std::int64_t{rows.rows()}, BytesOf(rows));
}

void AddImages(const SqliteDatabase& database, const std::vector<NewColmapImage>& images) {
  SqliteStatement insert(database, "INSERT INTO images(image_id, name, camera_id) VALUES(?, ?, ?)");
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto id = static_cast<std::int64_t>(i) + 1;
    insert.Run(id, images[i].name, static_cast<std::int64_t>(images[i].camera) + 1);
    AddKeypoints(database, id, images[i]);
  }
}

void AddMatches(const SqliteDatabase& database, const std::map<ColmapPair, MatchIndices>& matches) {
  SqliteStatement insert(database, "INSERT INTO matches(pair_id, rows, cols, data) VALUES(?, ?, 2, ?)");
  for (const auto& [pair, rows] : matches) {
    const Eigen::Matrix<std::uint32_t, Eigen::Dynamic, 2, Eigen::RowMajor> unsigned_rows = rows.cast<std::uint32_t>();
    insert.Run(PairId(pair), std::int64_t{unsigned_rows.rows()}, BytesOf(unsigned_rows));
  }
}

void Fill(const std::string& path, const NewColmapDatabase& content) {
  const SqliteDatabase database(path, SqliteDatabase::Access::kCreate);
  database.Execute(kSchema);
  SqliteTransaction transaction(database);
  AddCameras(database, content.cameras);
  AddImages(database, content.images);
  AddMatches(database, content.matches);
  transaction.Commit();
}

}  // namespace

void CreateColmapDatabase(const std::string& path, const NewColmapDatabase& content) {
  WriteFileAtomically(path, [&](const std::string& temporary) {
    try {
      Fill(temporary, content);
    } catch (const Error& error) {
      // Its messages begin with the temporary file, which nobody knows.
      const std::string what = error.what();
      throw Error(path + (what.starts_with(temporary) ? what.substr(temporary.size()) : ": " + what));
    }
  });
}

}  // namespace diffsac
