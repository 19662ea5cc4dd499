#include "lab/colmap/sqlite.h"

#include <sqlite3.h>

#include <cstring>
#include <filesystem>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr int kBusyMilliseconds = 2000;

// A path as SQLite's URI, in which '?', '#' and '%' mean something.
std::string UriOf(const std::string& path) {
  std::string uri = "file:";
  for (const char c : fs::absolute(path).string()) {
    if (c == '?' || c == '#' || c == '%') {
      constexpr char kDigits[] = "0123456789abcdef";
      uri += {'%', kDigits[c / 16], kDigits[c % 16]};
    } else {
      uri += c;
    }
  }
  return uri;
}

}  // namespace

void SqliteDatabase::Close::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }

SqliteDatabase::SqliteDatabase(const std::string& path, Access access) : path_(path) {
  std::error_code code;
  if (access == Access::kCreate) {
    Open(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
    return;
  }
  if (!fs::is_regular_file(path, code)) throw Error(path + ": no such file");
  if (access == Access::kWrite) {
    Open(path, SQLITE_OPEN_READWRITE);
    Execute("PRAGMA schema_version");
    return;
  }
  try {
    Open(path, SQLITE_OPEN_READONLY);
    Execute("PRAGMA schema_version");
  } catch (const Error&) {
    // COLMAP's databases keep a journal beside them even for readers, which a read-only folder does not allow. Where
    // nobody has left one, the file alone is all of the database.
    const int error = sqlite3_errcode(handle());
    const bool has_journal = fs::exists(path + "-wal", code) && fs::file_size(path + "-wal", code) > 0;
    if ((error != SQLITE_CANTOPEN && error != SQLITE_READONLY) || has_journal) throw;
    Open(UriOf(path) + "?immutable=1", SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
  }
}

void SqliteDatabase::Open(const std::string& name, int flags) {
  sqlite3* handle = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &handle, flags, nullptr);
  handle_.reset(handle);
  if (code != SQLITE_OK) Fail(code, "");
  sqlite3_busy_timeout(handle, kBusyMilliseconds);
}

void SqliteDatabase::Execute(const char* sql) const {
  const int code = sqlite3_exec(handle(), sql, nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) Fail(code, "");
}

std::vector<std::string> SqliteDatabase::Columns(const std::string& table) const {
  std::vector<std::string> columns;
  SqliteStatement statement(*this, "SELECT name FROM pragma_table_info('" + table + "')");
  while (statement.Step()) columns.push_back(statement.Text(0));
  return columns;
}

void SqliteDatabase::Fail(int code, const std::string& what) const {
  const std::string place = path_ + (what.empty() ? "" : ": " + what) + ": ";
  switch (code & 0xff) {
    case SQLITE_NOTADB:
      throw Error(place + "not an SQLite database");
    case SQLITE_CORRUPT:
      throw Error(place + "damaged or truncated");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw Error(place + "locked by another program (is COLMAP at work on it?)");
    case SQLITE_READONLY:
      throw Error(place + "cannot be written");
    default:
      throw Error(place + (handle() != nullptr ? sqlite3_errmsg(handle()) : sqlite3_errstr(code)));
  }
}

void SqliteStatement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

SqliteStatement::SqliteStatement(const SqliteDatabase& database, const std::string& sql) : database_(database) {
  sqlite3_stmt* statement = nullptr;
  Check(sqlite3_prepare_v2(database.handle(), sql.c_str(), -1, &statement, nullptr));
  statement_.reset(statement);
}

void SqliteStatement::Check(int code) const {
  if (code != SQLITE_OK) database_.Fail(code, "");
}

void SqliteStatement::Bind(int parameter, std::int64_t value) {
  Check(sqlite3_bind_int64(statement_.get(), parameter, value));
}

void SqliteStatement::Bind(int parameter, std::span<const std::byte> blob) {
  // A null pointer would bind NULL instead of a blob without bytes.
  const void* data = blob.empty() ? static_cast<const void*>("") : blob.data();
  Check(sqlite3_bind_blob64(statement_.get(), parameter, data, blob.size(), SQLITE_TRANSIENT));
}

void SqliteStatement::Bind(int parameter, const std::string& text) {
  Check(sqlite3_bind_text(statement_.get(), parameter, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT));
}

bool SqliteStatement::Step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  const int reset = sqlite3_reset(statement_.get());
  if (code != SQLITE_DONE) database_.Fail(reset, "");
  return false;
}

void SqliteStatement::Reset() { sqlite3_reset(statement_.get()); }

std::int64_t SqliteStatement::Integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }

std::string SqliteStatement::Text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  return text == nullptr ? "" : std::string(text, sqlite3_column_bytes(statement_.get(), column));
}

std::span<const std::byte> SqliteStatement::Blob(int column) const {
  const auto* bytes = static_cast<const std::byte*>(sqlite3_column_blob(statement_.get(), column));
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

SqliteTransaction::SqliteTransaction(const SqliteDatabase& database) : database_(database) {
  database.Execute("BEGIN IMMEDIATE");
}

SqliteTransaction::~SqliteTransaction() {
  if (open_) sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void SqliteTransaction::Commit() {
  database_.Execute("COMMIT");
  open_ = false;
}

}  // namespace diffsac
