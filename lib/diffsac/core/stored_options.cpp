#include "diffsac/core/stored_options.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "diffsac/core/former_names.h"
#include "diffsac/core/safetensors_header.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

/// The value of a key, or of its former name; null pointer where it is absent or null.
const nlohmann::json* Find(const nlohmann::json& object, const std::string& key) {
  auto found = object.find(key);
  if (found == object.end()) found = object.find(FormerName(key));
  return found == object.end() || found->is_null() ? nullptr : &*found;
}

/// One of the names, or a former one of them.
std::string NameOf(const nlohmann::json& json, const std::vector<std::string>& names) {
  const std::string name = json.is_string() ? json.get<std::string>() : "";
  return std::find(names.begin(), names.end(), name) != names.end() ? name : CurrentName(name);
}

/// A checked number; false for another type or one out of range.
template <class Number>
bool Convert(const nlohmann::json& json, Number* value, double least, double most) {
  if (std::is_integral_v<Number> ? !json.is_number_integer() : !json.is_number()) return false;
  const double number = json.get<double>();
  if (!(number >= least && number <= most)) return false;
  *value = json.get<Number>();
  return true;
}

}  // namespace

struct StoredOptions::Value {
  nlohmann::json json;
};

StoredOptions::StoredOptions(const std::string& text, const std::string& name) : place_(name + ":") {
  auto value = std::make_shared<Value>();
  value->json = nlohmann::json::parse(text, nullptr, false);
  if (!value->json.is_object()) throw Error(name + ": not valid JSON: expected an object");
  value_ = std::move(value);
}

StoredOptions::StoredOptions(std::shared_ptr<const Value> value, std::string place)
    : value_(std::move(value)), place_(std::move(place)) {}

void StoredOptions::Fail(const std::string& key, const std::string& expected) const {
  throw Error(place_ + (place_.ends_with(':') ? " " : ".") + key + ": expected " + expected);
}

void StoredOptions::Require(bool ok, const char* key, const std::string& expected) const {
  if (!ok) Fail(key, expected);
}

bool StoredOptions::Has(const std::string& key) const { return Find(value_->json, key) != nullptr; }

StoredOptions StoredOptions::Sub(const std::string& key) const {
  auto inner = std::make_shared<Value>();
  inner->json = nlohmann::json::object();
  if (const nlohmann::json* found = Find(value_->json, key)) {
    if (!found->is_object()) Fail(key, "a map");
    inner->json = *found;
  }
  return {std::move(inner), place_ + (place_.ends_with(':') ? " " : ".") + key};
}

void StoredOptions::Read(const char* key, bool* value) const {
  const nlohmann::json* found = Find(value_->json, key);
  if (found == nullptr) return;
  if (!found->is_boolean()) Fail(key, "true or false");
  *value = found->get<bool>();
}

void StoredOptions::Read(const char* key, std::string* value) const {
  const nlohmann::json* found = Find(value_->json, key);
  if (found == nullptr) return;
  if (!found->is_string()) Fail(key, "a text");
  *value = found->get<std::string>();
}

void StoredOptions::Read(const char* key, int* value, double least, double most) const {
  const nlohmann::json* found = Find(value_->json, key);
  if (found != nullptr && !Convert(*found, value, least, most)) Fail(key, "another whole number");
}

void StoredOptions::Read(const char* key, std::int64_t* value, double least, double most) const {
  const nlohmann::json* found = Find(value_->json, key);
  if (found != nullptr && !Convert(*found, value, least, most)) Fail(key, "another whole number");
}

void StoredOptions::Read(const char* key, double* value, double least, double most) const {
  const nlohmann::json* found = Find(value_->json, key);
  if (found != nullptr && !Convert(*found, value, least, most)) Fail(key, "another number");
}

std::string StoredOptions::Name(const std::string& key, const std::vector<std::string>& names) const {
  const std::string name = NameOf(*Find(value_->json, key), names);
  if (std::find(names.begin(), names.end(), name) == names.end()) Fail(key, "another name than " + Shown(name));
  return name;
}

std::vector<std::string> StoredOptions::NameList(const std::string& key, const std::vector<std::string>& names) const {
  const nlohmann::json* found = Find(value_->json, key);
  if (!found->is_array()) Fail(key, "a list");
  std::vector<std::string> list;
  for (const nlohmann::json& item : *found) {
    list.push_back(NameOf(item, names));
    if (std::find(names.begin(), names.end(), list.back()) == names.end())
      Fail(key, "another name than " + Shown(list.back()));
  }
  return list;
}

}  // namespace diffsac
