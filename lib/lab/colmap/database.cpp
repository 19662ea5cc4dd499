#include "lab/colmap/database.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

constexpr std::int64_t kMaxImages = 2147483647;

// What of COLMAP's schema is read or written here.
const std::vector<std::pair<std::string, std::vector<std::string>>>& Schema() {
  static const std::vector<std::pair<std::string, std::vector<std::string>>> schema = {
      {"cameras", {"camera_id", "model", "width", "height", "params", "prior_focal_length"}},
      {"images", {"image_id", "name", "camera_id"}},
      {"keypoints", {"image_id", "rows", "cols", "data"}},
      {"descriptors", {"image_id", "rows", "cols", "data"}},
      {"matches", {"pair_id", "rows", "cols", "data"}},
      {"two_view_geometries", {"pair_id", "rows", "cols", "data", "config", "F", "E", "H", "qvec", "tvec"}}};
  return schema;
}

// rows, cols and data of the current row, from `column` on, as numbers of type Value.
template <class Value>
Eigen::Matrix<Value, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> ReadMatrix(const SqliteStatement& statement,
                                                                                 int column, const std::string& place) {
  const std::int64_t rows = statement.Integer(column), cols = statement.Integer(column + 1);
  const auto blob = statement.Blob(column + 2);
  const auto size = static_cast<std::int64_t>(blob.size() / sizeof(Value));
  const bool fits = rows >= 0 && cols >= 0 && blob.size() % sizeof(Value) == 0 &&
                    (rows == 0 || cols == 0 ? size == 0 : size % rows == 0 && size / rows == cols);
  if (!fits)
    throw Error(place + ": expected " + std::to_string(rows) + " x " + std::to_string(cols) + " values of " +
                std::to_string(sizeof(Value)) + " bytes, found " + std::to_string(blob.size()) + " bytes");
  Eigen::Matrix<Value, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> matrix(rows, cols);
  if (!blob.empty()) std::memcpy(matrix.data(), blob.data(), blob.size());
  return matrix;
}

std::string PairText(const ColmapDatabase& database, const ColmapPair& pair) {
  return "matches of " + database.NameOf(pair.image1) + " and " + database.NameOf(pair.image2);
}

std::string StemOf(const std::string& file) {
  const std::size_t slash = file.rfind('/'), dot = file.rfind('.');
  const bool has_extension = dot != std::string::npos && dot > (slash == std::string::npos ? 0 : slash + 1);
  std::string name = has_extension ? file.substr(0, dot) : file;
  for (char& c : name)
    if (c == '-' || c == '/') c = '_';
  return name;
}

}  // namespace

std::int64_t PairId(const ColmapPair& pair) { return kMaxImages * pair.image1 + pair.image2; }

ColmapPair PairOfId(std::int64_t pair_id) {
  const std::int64_t image2 = pair_id % kMaxImages;
  return {(pair_id - image2) / kMaxImages, image2};
}

ColmapDatabase::ColmapDatabase(const std::string& path, SqliteDatabase::Access access) : sqlite_(path, access) {
  CheckSchema(access != SqliteDatabase::Access::kRead);
  ReadCameras();
  ReadImages();
}

void ColmapDatabase::CheckSchema(bool writes) {
  for (const auto& [table, columns] : Schema()) {
    const std::vector<std::string> found = sqlite_.Columns(table);
    // Those of 2016 call them inlier_matches; nobody reads them here.
    if (!writes && table == "two_view_geometries") continue;
    if (!writes && found.empty() && table == "descriptors") continue;
    if (found.empty()) throw Error(path() + ": no database of COLMAP: it has no table '" + table + "'");
    for (const std::string& column : columns) {
      if (std::find(found.begin(), found.end(), column) != found.end()) continue;
      if (!writes && column == "prior_focal_length") {
        has_prior_ = false;
        continue;
      }
      throw Error(
          path() + ": table '" + table + "' has no column '" + column +
          "': expected a database of COLMAP 3.8 or later, which brings older ones up to date when it opens them");
    }
  }
}

void ColmapDatabase::ReadCameras() {
  SqliteStatement rows(sqlite_, std::string("SELECT camera_id, model, width, height, ") +
                                    (has_prior_ ? "prior_focal_length" : "0") + ", params FROM cameras");
  while (rows.Step()) {
    ColmapCamera camera;
    camera.model = static_cast<int>(rows.Integer(1));
    camera.size = {static_cast<int>(rows.Integer(2)), static_cast<int>(rows.Integer(3))};
    camera.has_prior_focal_length = rows.Integer(4) != 0;
    const auto blob = rows.Blob(5);
    if (blob.size() % sizeof(double) != 0)
      LogWarning(path() + ": camera " + std::to_string(rows.Integer(0)) + ": its parameters are no doubles");
    else
      camera.parameters.resize(blob.size() / sizeof(double));
    if (!camera.parameters.empty()) std::memcpy(camera.parameters.data(), blob.data(), blob.size());
    cameras_[rows.Integer(0)] = std::move(camera);
  }
}

void ColmapDatabase::ReadImages() {
  std::string problem;
  SqliteStatement rows(sqlite_, "SELECT image_id, name, camera_id FROM images");
  while (rows.Step()) {
    const std::int64_t id = rows.Integer(0);
    if (cameras_.contains(rows.Integer(2))) {
      images_[id] = {rows.Text(1), rows.Integer(2)};
      continue;
    }
    problem = path() + ": image '" + rows.Text(1) + "': there is no camera " + std::to_string(rows.Integer(2));
    LogWarning("left out: " + problem);
  }
  if (images_.empty() && !problem.empty()) throw Error(problem);
  if (images_.empty()) throw Error(path() + ": it holds no images (colmap feature_extractor fills it)");
}

ColmapDatabase::StoredKeypoints ColmapDatabase::ReadKeypoints(std::int64_t image) const {
  const std::string place = path() + ": keypoints of " + NameOf(image);
  SqliteStatement statement(sqlite_, "SELECT rows, cols, data FROM keypoints WHERE image_id = ?");
  statement.Bind(1, image);
  if (!statement.Step()) return StoredKeypoints(0, 2);
  const StoredKeypoints stored = ReadMatrix<float>(statement, 0, place);
  if (stored.rows() == 0) return StoredKeypoints(0, 2);
  if (stored.cols() < 2)
    throw Error(place + ": expected x y and more, found " + std::to_string(stored.cols()) + " columns");
  return stored;
}

PointMatrix ColmapDatabase::Keypoints(std::int64_t image) const {
  return ReadKeypoints(image).leftCols<2>().cast<double>();
}

// Columns are x y, x y scale orientation, or x y and the affine shape a11 a12 a21 a22.
PointMatrix ColmapDatabase::KeypointFrames(std::int64_t image) const {
  const PointMatrix stored = ReadKeypoints(image).cast<double>();
  if (stored.rows() == 0 || (stored.cols() != 4 && stored.cols() != 6)) return {};
  PointMatrix frames(stored.rows(), 2);
  for (Eigen::Index i = 0; i < stored.rows(); ++i) {
    if (stored.cols() == 4) {
      frames.row(i) << std::log(stored(i, 2)), stored(i, 3);
    } else {
      const double along = std::hypot(stored(i, 2), stored(i, 4)), across = std::hypot(stored(i, 3), stored(i, 5));
      frames.row(i) << std::log(0.5 * (along + across)), std::atan2(stored(i, 4), stored(i, 2));
    }
  }
  const bool known = frames.allFinite() && (frames.rowwise() - frames.row(0)).cwiseAbs().maxCoeff() > 0.0;
  return known ? frames : PointMatrix();
}

ColmapDescriptors ColmapDatabase::Descriptors(std::int64_t image) const {
  const std::string place = path() + ": descriptors of " + NameOf(image);
  SqliteStatement statement(sqlite_, "SELECT rows, cols, data FROM descriptors WHERE image_id = ?");
  statement.Bind(1, image);
  if (!statement.Step()) return {};
  ColmapDescriptors stored = ReadMatrix<std::uint8_t>(statement, 0, place);
  if (stored.rows() > 0 && stored.rows() != KeypointCount(image))
    throw Error(place + ": " + std::to_string(stored.rows()) + " rows, but " + std::to_string(KeypointCount(image)) +
                " keypoints");
  return stored;
}

std::int64_t ColmapDatabase::KeypointCount(std::int64_t image) const {
  SqliteStatement statement(sqlite_, "SELECT rows FROM keypoints WHERE image_id = ?");
  statement.Bind(1, image);
  return statement.Step() ? statement.Integer(0) : 0;
}

namespace {

std::string TableOf(bool verified) { return verified ? "two_view_geometries" : "matches"; }

}  // namespace

std::vector<ColmapPair> ColmapDatabase::MatchedPairs(bool verified) const {
  std::vector<ColmapPair> pairs;
  std::size_t left_out = 0;
  SqliteStatement statement(sqlite_, "SELECT pair_id FROM " + TableOf(verified) + " WHERE rows > 0 ORDER BY pair_id");
  while (statement.Step()) {
    const ColmapPair pair = PairOfId(statement.Integer(0));
    if (images_.contains(pair.image1) && images_.contains(pair.image2))
      pairs.push_back(pair);
    else
      ++left_out;
  }
  if (left_out > 0)
    LogWarning(path() + ": left out " + std::to_string(left_out) + " pairs of " +
               std::to_string(left_out + pairs.size()) + ", of images that are not there");
  return pairs;
}

MatchIndices ColmapDatabase::Matches(const ColmapPair& pair, bool verified) const {
  const std::string place = path() + ": " + PairText(*this, pair);
  SqliteStatement statement(sqlite_, "SELECT rows, cols, data FROM " + TableOf(verified) + " WHERE pair_id = ?");
  statement.Bind(1, PairId(pair));
  if (!statement.Step()) return MatchIndices(0, 2);
  const auto stored = ReadMatrix<std::uint32_t>(statement, 0, place);
  if (stored.rows() == 0) return MatchIndices(0, 2);
  if (stored.cols() != 2)
    throw Error(place + ": expected two keypoints a row, found " + std::to_string(stored.cols()) + " columns");
  const std::int64_t images[] = {pair.image1, pair.image2};
  for (int side = 0; side < 2; ++side) {
    const std::int64_t count = KeypointCount(images[side]);
    const std::int64_t largest = stored.col(side).maxCoeff();
    if (largest >= count)
      throw Error(place + ": keypoint " + std::to_string(largest) + " of " + NameOf(images[side]) + ", which has " +
                  (count == 0 ? "none" : std::to_string(count)));
  }
  return stored.cast<std::int32_t>();
}

std::map<std::int64_t, std::string> PairNames(const std::map<std::int64_t, std::string>& files) {
  std::map<std::string, int> count;
  for (const auto& [id, file] : files) ++count[StemOf(file)];
  std::map<std::int64_t, std::string> names;
  std::map<std::string, std::string> file_of;
  for (const auto& [id, file] : files) {
    std::string name = StemOf(file);
    if (count[name] > 1) name += "_" + std::to_string(id);
    const auto [other, is_new] = file_of.emplace(name, file);
    if (!is_new) throw Error("the images '" + other->second + "' and '" + file + "' cannot be told apart: rename one");
    names[id] = std::move(name);
  }
  return names;
}

std::map<std::int64_t, std::string> PairNames(const ColmapDatabase& database) {
  std::map<std::int64_t, std::string> files;
  for (const auto& [id, image] : database.images()) files[id] = image.name;
  return PairNames(files);
}

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
