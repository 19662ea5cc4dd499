#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "lab/colmap/database.h"

namespace diffsac {

/// A new database with the tables of COLMAP 3.8, to be filled as a test likes.
class DatabaseMaker {
 public:
  explicit DatabaseMaker(const std::string& path) {
    if (sqlite3_open(path.c_str(), &handle_) != SQLITE_OK) throw std::runtime_error("cannot make " + path);
    Run("CREATE TABLE cameras (camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, model INTEGER NOT NULL, width "
        "INTEGER "
        "NOT NULL, height INTEGER NOT NULL, params BLOB, prior_focal_length INTEGER NOT NULL)");
    Run("CREATE TABLE images (image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, name TEXT NOT NULL UNIQUE, "
        "camera_id "
        "INTEGER NOT NULL, prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL, prior_tx REAL, prior_ty REAL, "
        "prior_tz REAL)");
    for (const char* table : {"keypoints", "descriptors"})
      Run("CREATE TABLE " + std::string(table) +
          " (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB)");
    Run("CREATE TABLE matches (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, "
        "data "
        "BLOB)");
    Run("CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER "
        "NOT "
        "NULL, data BLOB, config INTEGER NOT NULL, F BLOB, E BLOB, H BLOB, qvec BLOB, tvec BLOB)");
  }
  ~DatabaseMaker() { sqlite3_close(handle_); }
  DatabaseMaker(const DatabaseMaker&) = delete;
  DatabaseMaker& operator=(const DatabaseMaker&) = delete;

  void Run(const std::string& sql) {
    if (sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
      throw std::runtime_error(sql + ": " + sqlite3_errmsg(handle_));
  }

  void AddCamera(int id, int model, const std::vector<double>& parameters, bool prior = true,
                 ImageSize size = {640, 480}) {
    Insert("INSERT INTO cameras VALUES(" + Text(id) + "," + Text(model) + "," + Text(size.width) + "," +
               Text(size.height) + ",?1," + Text(prior ? 1 : 0) + ")",
           parameters.data(), parameters.size() * sizeof(double));
  }
  void AddImage(int id, const std::string& name, int camera = 1) {
    Run("INSERT INTO images(image_id, name, camera_id) VALUES(" + Text(id) + ",'" + name + "'," + Text(camera) + ")");
  }
  /// N × 2, COLMAP's pixels; `columns` as in one of COLMAP's versions: 2, 4 or 6.
  // `shapes`: what stands behind x y; 7 everywhere unless given.
  void AddKeypoints(int image, const PointMatrix& points, int columns = 6, const Eigen::MatrixXd& shapes = {}) {
    Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows(points.rows(), columns);
    rows.setConstant(7.0f);
    rows.leftCols<2>() = points.cast<float>();
    if (shapes.size() > 0) rows.rightCols(columns - 2) = shapes.cast<float>();
    Insert(InsertRows("keypoints", image, rows.rows(), columns), rows.data(), rows.size() * sizeof(float));
  }
  void AddDescriptors(int image, const ColmapDescriptors& rows) {
    Insert(InsertRows("descriptors", image, rows.rows(), rows.cols()), rows.data(), rows.size());
  }
  void AddMatches(const ColmapPair& pair, const MatchIndices& matches) {
    const Eigen::Matrix<std::uint32_t, Eigen::Dynamic, 2, Eigen::RowMajor> rows = matches.cast<std::uint32_t>();
    Insert(InsertRows("matches", PairId(pair), rows.rows(), 2), rows.data(), rows.size() * sizeof(std::uint32_t));
  }

 private:
  template <class Number>
  static std::string Text(Number number) {
    return std::to_string(number);
  }
  static std::string InsertRows(const std::string& table, std::int64_t id, Eigen::Index rows, Eigen::Index cols) {
    return "INSERT INTO " + table + " VALUES(" + Text(id) + "," + Text(rows) + "," + Text(cols) + ",?1)";
  }
  void Insert(const std::string& sql, const void* data, std::size_t bytes) {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(handle_, sql.c_str(), -1, &statement, nullptr);
    sqlite3_bind_blob(statement, 1, data, static_cast<int>(bytes), SQLITE_TRANSIENT);
    const int code = sqlite3_step(statement);
    sqlite3_finalize(statement);
    if (code != SQLITE_DONE) throw std::runtime_error(sql + ": " + sqlite3_errmsg(handle_));
  }

  sqlite3* handle_ = nullptr;
};

/// N rows (i, count - 1 - i): matches that no other order of rows gives.
inline MatchIndices Crossed(int count) {
  MatchIndices matches(count, 2);
  for (int i = 0; i < count; ++i) matches.row(i) << i, count - 1 - i;
  return matches;
}

}  // namespace diffsac
