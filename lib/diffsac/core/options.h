#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace diffsac {

/// A value, or a closed range to draw from. YAML: `0.5` or `[0.1, 0.8]`.
struct Range {
  double low = 0.0;
  double high = 0.0;
  Range() = default;
  Range(double value) : low(value), high(value) {}
  Range(double low_value, double high_value) : low(low_value), high(high_value) {}
  bool operator==(const Range&) const = default;
};

/// Limits of a numeric option; both ends are valid values unless `exclusive_min`.
struct Limits {
  double min = -1e300;
  double max = 1e300;
  bool exclusive_min = false;
};
inline Limits AtLeast(double min) { return {min, 1e300, false}; }
inline Limits Positive() { return {0.0, 1e300, true}; }
inline Limits Within(double min, double max) { return {min, max, false}; }

/// A parsed YAML document that remembers where each value stood (file and line, or the --set that gave it).
/// Cheap to copy; copies share the document.
class Config {
 public:
  /// An empty document: every option keeps its default.
  Config();
  /// Reads a file. A top-level `include: other.yaml` (path relative to this file) is read first and overridden key by
  /// key. Throws Error naming the file and line when it cannot be read or parsed.
  static Config FromFile(const std::string& path);
  /// Parses text; `name` stands for the file in messages.
  static Config FromString(const std::string& text, const std::string& name = "<string>");

  /// Applies `a.b.c=value` (value is YAML) in place of the old value. Creates missing maps; a number in the path
  /// indexes a sequence. Throws Error when the text has no '=' or the path runs through a plain value.
  void Set(const std::string& assignment);

  bool Has(const std::string& dotted_path) const;
  /// The sub-document at `a.b`, empty when absent. Messages keep the whole path.
  Config Sub(const std::string& dotted_path) const;
  /// The elements of a sequence at a path, empty when absent. Throws Error when it is no sequence.
  std::vector<Config> Sequence(const std::string& dotted_path) const;
  /// One value as text, without quotes. Throws Error when it is absent or no plain value.
  std::string Text(const std::string& dotted_path = "") const;
  /// The document as YAML text.
  std::string Dump() const;

  /// "file.yaml:12: key.path" for messages.
  std::string Where(const std::string& dotted_path = "") const;

  struct Impl;
  std::shared_ptr<Impl> impl_;
};

/// Binds a plain options struct to YAML in one place: the same `Bind` function reads it, checks it, writes the
/// resolved values and knows every valid key.
///
/// Example:
/// ```
/// struct LineOptions {
///   int num_points = 100;
///   std::string noise = "gaussian";
///   void Bind(OptionsBinder& b) {
///     b.Field("num_points", num_points, AtLeast(2));
///     b.Choice("noise", noise, {"gaussian", "uniform"});
///   }
/// };
/// auto options = ReadOptions<LineOptions>(config.Sub("data"));   // throws Error: file, line, nearest valid key
/// std::string yaml = WriteOptions(options);
/// ```
class OptionsBinder {
 public:
  void Field(const char* key, bool& value);
  void Field(const char* key, int& value, Limits limits = {});
  void Field(const char* key, std::int64_t& value, Limits limits = {});
  void Field(const char* key, std::uint64_t& value);
  void Field(const char* key, double& value, Limits limits = {});
  void Field(const char* key, std::string& value);
  void Field(const char* key, Range& value, Limits limits = {});
  void Field(const char* key, std::vector<double>& value, Limits limits = {});
  void Field(const char* key, std::vector<int>& value, Limits limits = {});
  void Field(const char* key, std::vector<std::string>& value);
  /// A string out of a fixed list; anything else is an error that names the nearest.
  void Choice(const char* key, std::string& value, std::initializer_list<const char*> choices);
  /// Strings out of a fixed list.
  void Choices(const char* key, std::vector<std::string>& value, std::initializer_list<const char*> choices);
  /// A nested options struct with its own `Bind`.
  template <class Options>
  void Group(const char* key, Options& options) {
    GroupWith(key, [&options](OptionsBinder& inner) { options.Bind(inner); });
  }
  void GroupWith(const char* key, const std::function<void(OptionsBinder&)>& bind);
  /// Accepts a key whose value is read elsewhere (a sub-document of another reader's).
  void Ignore(const char* key);
  /// A check across fields: when reading and `ok` is false, throws Error with the place of `key`.
  void Require(bool ok, const char* key, const std::string& expected);

  /// Used by ReadOptions and WriteOptions.
  struct Impl;
  explicit OptionsBinder(Impl* impl) : impl_(impl) {}

 private:
  Impl* impl_;
};

void ReadOptionsWith(const Config& config, const std::function<void(OptionsBinder&)>& bind);
std::string WriteOptionsWith(const std::function<void(OptionsBinder&)>& bind);

/// Fills defaults from `config`. Unknown key, wrong type or out of range: Error with file, line and nearest key.
template <class Options>
Options ReadOptions(const Config& config, Options options = {}) {
  ReadOptionsWith(config, [&options](OptionsBinder& b) { options.Bind(b); });
  return options;
}

/// The resolved options as YAML; reads back to equal options. Throws std::logic_error for a number that is not finite,
/// which no reader accepts.
template <class Options>
std::string WriteOptions(Options options) {
  return WriteOptionsWith([&options](OptionsBinder& b) { options.Bind(b); });
}

/// The candidate with the smallest edit distance to `word`, for "did you mean".
std::string NearestWord(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace diffsac
