#pragma once

#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/enum_names.h"

namespace diffsac {

/// Options as a checkpoint stores them: a JSON object. Keys that nobody reads are passed over. Absent keys leave the
/// value as it was. Keys and names of 0.2 are read (former_names.h). All throw Error that names file and key for a
/// value of another type or out of range.
class StoredOptions {
 public:
  /// name: stands for the file in messages.
  StoredOptions(const std::string& text, const std::string& name);

  bool Has(const std::string& key) const;
  /// The object behind a key, empty where it is absent.
  StoredOptions Sub(const std::string& key) const;

  void Read(const char* key, bool* value) const;
  void Read(const char* key, std::string* value) const;
  void Read(const char* key, int* value, double least, double most) const;
  void Read(const char* key, std::int64_t* value, double least, double most) const;
  void Read(const char* key, double* value, double least, double most) const;
  template <NamedEnum Enum>
  void Read(const char* key, Enum* value) const {
    if (Has(key)) *value = FromString<Enum>(Name(key, NamesOf<Enum>()));
  }
  template <NamedEnum Enum>
  void Read(const char* key, std::vector<Enum>* values) const {
    if (!Has(key)) return;
    values->clear();
    for (const std::string& name : NameList(key, NamesOf<Enum>())) values->push_back(FromString<Enum>(name));
  }
  /// Throws Error naming the key unless `ok`.
  void Require(bool ok, const char* key, const std::string& expected) const;

 private:
  struct Value;
  StoredOptions(std::shared_ptr<const Value> value, std::string place);
  std::string Name(const std::string& key, const std::vector<std::string>& names) const;
  std::vector<std::string> NameList(const std::string& key, const std::vector<std::string>& names) const;
  [[noreturn]] void Fail(const std::string& key, const std::string& expected) const;

  std::shared_ptr<const Value> value_;
  std::string place_;  ///< File, and the keys to here.
};

}  // namespace diffsac
