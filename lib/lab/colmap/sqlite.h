#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

namespace diffsac {

/// An SQLite database. All here throw Error with one line that starts with the file's path: no such file,
/// no database, damaged, locked by another program for more than two seconds, ...
class SqliteDatabase {
 public:
  enum class Access { kRead, kWrite, kCreate };  ///< kCreate: as kWrite, and a file that is not there is made.
  SqliteDatabase(const std::string& path, Access access);

  const std::string& path() const { return path_; }
  /// Runs statements without results.
  void Execute(const char* sql) const;
  /// The columns of a table, none where there is no such table.
  std::vector<std::string> Columns(const std::string& table) const;
  /// Error for the result code of a call that failed; `what` names the place in the database, may be empty.
  [[noreturn]] void Fail(int code, const std::string& what) const;
  sqlite3* handle() const { return handle_.get(); }

 private:
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  void Open(const std::string& name, int flags);

  std::string path_;
  std::unique_ptr<sqlite3, Close> handle_;
};

/// What a blob of these values holds.
template <class Values>
std::span<const std::byte> BytesOf(const Values& values) {
  return std::as_bytes(std::span(values.data(), static_cast<std::size_t>(values.size())));
}

/// A prepared statement: values in, rows out.
class SqliteStatement {
 public:
  /// The database must live longer.
  SqliteStatement(const SqliteDatabase& database, const std::string& sql);

  /// Parameter 1, 2, ... of the next run. A blob is copied.
  void Bind(int parameter, std::int64_t value);
  void Bind(int parameter, std::span<const std::byte> blob);
  void Bind(int parameter, const std::string& text);

  /// A run without rows, with these parameters from the first on.
  template <class... Values>
  void Run(const Values&... values) {
    int parameter = 0;
    (Bind(++parameter, values), ...);
    Step();
  }

  /// To the next row; false after the last one, and then the statement can run again.
  bool Step();
  /// Ends a run before its last row.
  void Reset();

  /// Of the current row, columns from 0. A blob's bytes hold until the next Step or Reset.
  std::int64_t Integer(int column) const;
  std::string Text(int column) const;
  std::span<const std::byte> Blob(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  void Check(int code) const;

  const SqliteDatabase& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

/// BEGIN, and ROLLBACK unless Commit was reached. Other writers wait or are told that it is locked.
class SqliteTransaction {
 public:
  explicit SqliteTransaction(const SqliteDatabase& database);
  ~SqliteTransaction();
  SqliteTransaction(const SqliteTransaction&) = delete;
  SqliteTransaction& operator=(const SqliteTransaction&) = delete;
  void Commit();

 private:
  const SqliteDatabase& database_;
  bool open_ = true;
};

}  // namespace diffsac
