#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/core/enum_names.h"
#include "diffsac/core/nearest_word.h"
#include "diffsac/core/range.h"
#include "lab/options/config.h"

namespace diffsac {

/// Limits of a numeric option; both ends are valid values unless `exclusive_min`.
struct Limits {
  double min = -1e300;
  double max = 1e300;
  bool exclusive_min = false;
};
inline Limits AtLeast(double min) { return {min, 1e300, false}; }
inline Limits Positive() { return {0.0, 1e300, true}; }
inline Limits Within(double min, double max) { return {min, max, false}; }

class OptionsBinder;
enum class Task : int;
struct ClassicalOptions;
struct ConsensusOptions;
struct DenoiserOptions;
struct DiffsacOptions;
struct LearnedOptions;
struct MinimalSamplerOptions;
struct NetworkOptions;
struct NoiseScheduleOptions;
struct PointFeaturesOptions;
struct ReverseSamplerOptions;
struct SetScorerOptions;
struct InstanceSearchOptions;

// Keys, limits and documentation of the library's structs, which know no configuration (bind.cpp).
void BindOptions(OptionsBinder& b, ConsensusOptions& options);
void BindOptions(OptionsBinder& b, MinimalSamplerOptions& options);
void BindOptions(OptionsBinder& b, InstanceSearchOptions& options);
void BindOptions(OptionsBinder& b, PointFeaturesOptions& options);
void BindOptions(OptionsBinder& b, NoiseScheduleOptions& options);
void BindOptions(OptionsBinder& b, ReverseSamplerOptions& options);
void BindOptions(OptionsBinder& b, DenoiserOptions& options);
void BindOptions(OptionsBinder& b, NetworkOptions& options);
void BindOptions(OptionsBinder& b, SetScorerOptions& options);
void BindOptions(OptionsBinder& b, ClassicalOptions& options);
void BindOptions(OptionsBinder& b, DiffsacOptions& options);
/// The keys of all learned rows but weighted_fit, whose key is the method's.
void BindShared(OptionsBinder& b, LearnedOptions& options);
/// The key `model`: the name of one of a task's models, "" for its own.
void BindModel(OptionsBinder& b, Task task, std::string* model);

/// A struct of options with a `Bind` of its own, or one of the library's with a BindOptions.
template <class Options>
concept Bindable = requires(Options& options, OptionsBinder& b) {
  options.Bind(b);
}
|| requires(Options& options, OptionsBinder& b) { BindOptions(b, options); };

template <Bindable Options>
void BindAny(OptionsBinder& b, Options& options) {
  if constexpr (requires { options.Bind(b); })
    options.Bind(b);
  else
    BindOptions(b, options);
}

/// Binds a plain options struct to a configuration in one place: the same `Bind` function reads it, checks it, writes
/// the resolved values, knows every valid key and describes it.
///
/// docs/extending.md has examples. A value is bound at once, so that what is bound later can depend on it. Besides
/// numbers and texts a field can be an enum with names, a struct with its own `Bind`, a list of either, an optional of
/// anything, or a sub-document that another reader reads (Config).
class OptionsBinder {
 public:
  OptionsBinder& Field(const char* key, bool& value);
  OptionsBinder& Field(const char* key, int& value, Limits limits = {});
  OptionsBinder& Field(const char* key, std::int64_t& value, Limits limits = {});
  OptionsBinder& Field(const char* key, std::uint64_t& value);
  OptionsBinder& Field(const char* key, double& value, Limits limits = {});
  OptionsBinder& Field(const char* key, std::string& value);
  OptionsBinder& Field(const char* key, Range& value, Limits limits = {});
  OptionsBinder& Field(const char* key, std::vector<double>& value, Limits limits = {});
  OptionsBinder& Field(const char* key, std::vector<int>& value, Limits limits = {});
  OptionsBinder& Field(const char* key, std::vector<std::string>& value);
  /// A sub-document as it stands, with the places of its values; an empty map where it is given without a value.
  OptionsBinder& Field(const char* key, Config& raw);

  /// One of the enum's names; anything else is an error that names the nearest. `allowed`: only some of them.
  template <NamedEnum Enum>
  OptionsBinder& Field(const char* key, Enum& value);
  template <NamedEnum Enum>
  OptionsBinder& Field(const char* key, Enum& value, std::initializer_list<Enum> allowed);
  template <NamedEnum Enum>
  OptionsBinder& Field(const char* key, std::vector<Enum>& values);

  /// A text out of a list, where the names are known only at run time or stand for nothing but themselves.
  OptionsBinder& Choice(const char* key, std::string& value, const std::vector<std::string>& choices);
  OptionsBinder& Choice(const char* key, std::string& value, std::initializer_list<const char*> choices);
  OptionsBinder& Choices(const char* key, std::vector<std::string>& value, const std::vector<std::string>& choices);
  OptionsBinder& Choices(const char* key, std::vector<std::string>& value, std::initializer_list<const char*> choices);

  /// A nested struct.
  template <Bindable Options>
  OptionsBinder& Field(const char* key, Options& options);
  template <Bindable Options>
  OptionsBinder& Group(const char* key, Options& options) {
    return Field(key, options);
  }
  OptionsBinder& GroupWith(const char* key, const std::function<void(OptionsBinder&)>& bind);

  /// A list of structs. What is given replaces what was there.
  template <Bindable Options>
  OptionsBinder& Field(const char* key, std::vector<Options>& items);
  OptionsBinder& ListWith(const char* key, std::size_t size, const std::function<void(std::size_t)>& resize,
                          const std::function<void(std::size_t, OptionsBinder&)>& bind);

  /// A value that may be absent: nothing is written for none, and `key: ~` reads as none.
  template <class Value, class... Limit>
  OptionsBinder& Field(const char* key, std::optional<Value>& value, Limit... limits);

  /// Every key of this map that was not bound before this call, as it stands.
  OptionsBinder& Rest(Config& raw);

  // About the field just bound:

  /// What it means, with its unit, for the documentation.
  OptionsBinder& Help(const std::string& text);
  /// The field acts only where `acts` is true; `when` says so ("score: msac"). Elsewhere giving it is an error, and it
  /// is not written.
  OptionsBinder& OnlyIf(bool acts, const std::string& when);

  // Checks across fields. They throw Error with the place of `key` (a dotted path below this map) after all fields are
  // bound and the keys checked, for a misspelt key is often their cause.

  /// "expected ..." unless `ok`.
  OptionsBinder& Require(bool ok, const char* key, const std::string& expected);
  /// The same in other words.
  OptionsBinder& Reject(bool wrong, const std::string& key, const std::string& message);

  /// Used by ReadOptions and its like.
  struct Impl;
  explicit OptionsBinder(Impl* impl) : impl_(impl) {}

 private:
  enum class Presence { kAbsent, kNone, kGiven };
  Presence StartOptional(const char* key, bool has_value);
  void DescribeAsNone();
  Impl* impl_;
};

/// What is known of one key, for documentation.
struct OptionDescription {
  std::string key;
  std::string type;           ///< As messages say it, with limits and choices: "an integer of at least 1".
  std::string default_value;  ///< As YAML; empty for maps and for what has none.
  std::string when;           ///< Acts only then ("score: msac"); empty: always.
  std::string help;
  std::vector<OptionDescription> children;  ///< The keys of a nested map, or of a list of maps.
};

void ReadOptionsWith(const Config& config, const std::function<void(OptionsBinder&)>& bind);
void ReadStoredOptionsWith(const Config& config, const std::function<void(OptionsBinder&)>& bind);
Config ToConfigWith(const std::function<void(OptionsBinder&)>& bind);
void CheckOptionsWith(const std::function<void(OptionsBinder&)>& bind);
std::vector<OptionDescription> DescribeOptionsWith(const std::function<void(OptionsBinder&)>& bind);

/// Fills defaults from `config`. Unknown key, wrong type or out of range: Error with file, line and nearest key.
template <class Options>
Options ReadOptions(const Config& config, Options options = {}) {
  ReadOptionsWith(config, [&options](OptionsBinder& b) { BindAny(b, options); });
  return options;
}

/// The same for what a program stored earlier (a checkpoint's configuration): keys that are unknown, or that do not
/// act, are passed over.
template <class Options>
Options ReadStoredOptions(const Config& config, Options options = {}) {
  ReadStoredOptionsWith(config, [&options](OptionsBinder& b) { BindAny(b, options); });
  return options;
}

/// The resolved options; reads back to equal options. Throws std::logic_error for a number that is not finite, which no
/// reader accepts.
template <class Options>
Config ToConfig(Options options) {
  return ToConfigWith([&options](OptionsBinder& b) { BindAny(b, options); });
}

/// Holds options made in C++ to the limits, choices and requirements that a file is held to. Throws Error naming the
/// key and what was expected.
template <class Options>
void CheckOptions(Options options) {
  CheckOptionsWith([&options](OptionsBinder& b) { BindAny(b, options); });
}

/// Every key with its default, in the order of `Bind`.
template <class Options>
std::vector<OptionDescription> DescribeOptions(Options options = {}) {
  return DescribeOptionsWith([&options](OptionsBinder& b) { BindAny(b, options); });
}

template <NamedEnum Enum>
OptionsBinder& OptionsBinder::Field(const char* key, Enum& value) {
  std::string name = ToString(value);
  Choice(key, name, NamesOf<Enum>());
  value = FromString<Enum>(name);
  return *this;
}

template <NamedEnum Enum>
OptionsBinder& OptionsBinder::Field(const char* key, Enum& value, std::initializer_list<Enum> allowed) {
  std::vector<std::string> names;
  for (const Enum one : allowed) names.push_back(ToString(one));
  std::string name = ToString(value);
  Choice(key, name, names);
  value = FromString<Enum>(name);
  return *this;
}

template <NamedEnum Enum>
OptionsBinder& OptionsBinder::Field(const char* key, std::vector<Enum>& values) {
  std::vector<std::string> names;
  for (const Enum value : values) names.push_back(ToString(value));
  Choices(key, names, NamesOf<Enum>());
  values.clear();
  for (const std::string& name : names) values.push_back(FromString<Enum>(name));
  return *this;
}

template <Bindable Options>
OptionsBinder& OptionsBinder::Field(const char* key, Options& options) {
  return GroupWith(key, [&options](OptionsBinder& inner) { BindAny(inner, options); });
}

template <Bindable Options>
OptionsBinder& OptionsBinder::Field(const char* key, std::vector<Options>& items) {
  return ListWith(
      key, items.size(), [&items](std::size_t size) { items.assign(size, Options()); },
      [&items](std::size_t index, OptionsBinder& inner) { BindAny(inner, items[index]); });
}

template <class Value, class... Limit>
OptionsBinder& OptionsBinder::Field(const char* key, std::optional<Value>& value, Limit... limits) {
  switch (StartOptional(key, value.has_value())) {
    case Presence::kAbsent:
      break;
    case Presence::kNone:
      value.reset();
      break;
    case Presence::kGiven: {
      const bool had_value = value.has_value();
      Value held = value.value_or(Value());
      Field(key, held, limits...);
      if (!had_value) DescribeAsNone();
      value = std::move(held);
      break;
    }
  }
  return *this;
}

/// The options that the key `type` chose, with that key beside them, and where the type has several sets of defaults
/// the key `preset`, which chose among these. Without a type: the keys beside it, for their description.
template <class Options>
struct TypedOptions {
  std::string type;
  Options options;
  std::string preset = {};
  std::vector<std::string> presets = {};
  void Bind(OptionsBinder& b) {
    if (!type.empty()) b.Choice("type", type, std::vector<std::string>{type});
    BindPreset(b, presets, &preset);
    BindAny(b, options);
  }
  static void BindPreset(OptionsBinder& b, const std::vector<std::string>& presets, std::string* preset) {
    if (!presets.empty()) b.Choice("preset", *preset, presets).Help("the options that the keys below change");
  }
};

}  // namespace diffsac
