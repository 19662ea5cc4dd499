#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "diffsac/core/status.h"
#include "lab/data/finite_points.h"
#include "lab/data/point_files.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"

namespace diffsac {
namespace {

static_assert(std::endian::native == std::endian::little, "the byte order of the machine is assumed below");

template <class T>
double ValueOf(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

// A type of values, under both of its names.
struct Scalar {
  std::string_view name, other_name;
  std::size_t bytes;
  double (*value)(const char*);
};

constexpr Scalar kScalars[] = {
    {"char", "int8", 1, ValueOf<std::int8_t>},    {"uchar", "uint8", 1, ValueOf<std::uint8_t>},
    {"short", "int16", 2, ValueOf<std::int16_t>}, {"ushort", "uint16", 2, ValueOf<std::uint16_t>},
    {"int", "int32", 4, ValueOf<std::int32_t>},   {"uint", "uint32", 4, ValueOf<std::uint32_t>},
    {"float", "float32", 4, ValueOf<float>},      {"double", "float64", 8, ValueOf<double>}};

struct Property {
  std::string_view name;
  const Scalar* type = nullptr;
  const Scalar* list_count = nullptr;  // the type of the list's length; null for a single value
};

struct Element {
  std::string_view name;
  std::uint64_t count = 0;
  std::vector<Property> properties = {};
};

// Reads the header, then row after row of what follows it.
class PlyReader {
 public:
  PlyReader(const std::string& path, std::string_view text) : path_(path), rest_(text) {}

  PointMatrix Read() {
    ReadHeader();
    for (const Element& element : elements_) {
      if (element.name == "vertex") return ReadVertices(element);
      // Rows without a value take no bytes, however many there are.
      for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i) ReadRow(element, i);
    }
    throw Error(path_ + ": no element 'vertex' in this PLY file");
  }

 private:
  using Words = std::vector<std::string_view>;

  [[noreturn]] void Fail(const std::string& message) const {
    throw Error(path_ + ":" + std::to_string(line_) + ": " + message);
  }

  std::string_view NextLine(const std::string& expected) {
    std::string_view line;
    ++line_;
    if (!TakeLine(&rest_, &line)) throw Error(path_ + ": truncated: the file ends at " + expected);
    return line;
  }

  void ReadHeader() {
    if (NextLine("its first line") != "ply") Fail("not a PLY file: expected 'ply' in the first line");
    for (;;) {
      const std::string_view line = NextLine("its header");
      const Words words = SplitWords(line, " \t");
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format" && words.size() > 1)
        format_ = words[1];
      else if (words[0] == "element" && words.size() == 3)
        elements_.push_back({words[1], Count(words[2])});
      else if (words[0] == "property" && !elements_.empty() && (words.size() == 3 || words.size() == 5))
        elements_.back().properties.push_back(PropertyOf(words));
      else
        Fail("PLY header line '" + std::string(line.substr(0, 60)) + "': expected a format, element or property");
    }
    ascii_ = format_ == "ascii", big_ = format_ == "binary_big_endian";
    if (!ascii_ && !big_ && format_ != "binary_little_endian")
      Fail("PLY format '" + std::string(format_) + "': expected ascii, binary_little_endian or binary_big_endian");
  }

  std::uint64_t Count(std::string_view word) const {
    std::uint64_t count = 0;
    const auto result = std::from_chars(word.data(), word.data() + word.size(), count);
    if (result.ec != std::errc() || result.ptr != word.data() + word.size()) Fail("expected 'element <name> <count>'");
    return count;
  }

  Property PropertyOf(const Words& words) const {
    const bool list = words.size() == 5;
    return {words.back(), TypeOf(words[words.size() - 2]), list ? TypeOf(words[2]) : nullptr};
  }

  const Scalar* TypeOf(std::string_view word) const {
    for (const Scalar& type : kScalars)
      if (word == type.name || word == type.other_name) return &type;
    Fail("unknown PLY type '" + std::string(word) + "'");
  }

  // A list is no coordinate.
  std::vector<std::size_t> CoordinatesOf(const Element& element) const {
    std::vector<std::size_t> columns;
    for (const char* name : {"x", "y", "z"}) {
      const auto found = std::find_if(element.properties.begin(), element.properties.end(),
                                      [&](const Property& p) { return p.name == name && p.list_count == nullptr; });
      if (found != element.properties.end())
        columns.push_back(static_cast<std::size_t>(found - element.properties.begin()));
      else if (name[0] != 'z')
        throw Error(path_ + ": the element 'vertex' has no property " + name);
    }
    return columns;
  }

  PointMatrix ReadVertices(const Element& element) {
    const std::vector<std::size_t> columns = CoordinatesOf(element);
    std::vector<double> flat;
    // A wrong count must not reserve more than the file can hold.
    flat.reserve(columns.size() * std::min<std::uint64_t>(element.count, rest_.size()));
    for (std::uint64_t i = 0; i < element.count; ++i) {
      ReadRow(element, i);
      for (const std::size_t column : columns) flat.push_back(row_[column]);
    }
    if (&element == &elements_.back() && rest_.find_first_not_of(" \t\r\n") != std::string_view::npos)
      WarnOnce(path_ + ": left out: what follows the " + std::to_string(element.count) +
               " points that the header announces");
    return Eigen::Map<const PointMatrix>(flat.data(), static_cast<Eigen::Index>(element.count),
                                         static_cast<Eigen::Index>(columns.size()));
  }

  // Fills row_ with the single values of one row of an element; lists are skipped. In text it is a line.
  void ReadRow(const Element& element, std::uint64_t index) {
    const std::string what =
        std::string(element.name) + " " + std::to_string(index + 1) + " of " + std::to_string(element.count);
    Words words;
    while (ascii_ && words.empty()) words = SplitWords(NextLine(what), " \t\r");
    std::size_t used = 0;
    row_.clear();
    for (const Property& property : element.properties) {
      row_.push_back(Value(property.list_count != nullptr ? *property.list_count : *property.type, what, words, &used));
      if (property.list_count == nullptr) continue;
      if (!(row_.back() >= 0.0)) throw Error(path_ + ": a list of negative length at " + what);
      for (double i = 0.0; i < row_.back(); ++i) Value(*property.type, what, words, &used);
    }
    if (used < words.size()) Fail(what + " has more values than the header says");
  }

  double Value(const Scalar& type, const std::string& what, const Words& words, std::size_t* used) {
    double value = 0.0;
    if (ascii_) {
      if (*used == words.size()) Fail(what + " has fewer values than the header says");
      const std::string_view word = words[(*used)++];
      if (!ParseNumber(word, &value)) Fail("expected a number, found '" + std::string(word.substr(0, 40)) + "'");
      return value;
    }
    if (rest_.size() < type.bytes) throw Error(path_ + ": truncated: the file ends at " + what);
    char bytes[8];
    std::copy_n(rest_.begin(), type.bytes, bytes);
    if (big_) std::reverse(bytes, bytes + type.bytes);
    rest_.remove_prefix(type.bytes);
    return type.value(bytes);
  }

  std::string path_;
  std::string_view rest_, format_;
  int line_ = 0;
  bool ascii_ = false, big_ = false;
  std::vector<Element> elements_;
  std::vector<double> row_;
};

}  // namespace

PointSet ReadPlyPoints(const std::string& path) {
  const std::string content = ReadFile(path);
  const std::filesystem::path file(path);
  PointSet set;
  set.name = file.filename().string();
  set.scene = std::filesystem::absolute(file).parent_path().filename().string();
  set.points = PlyReader(path, content).Read();
  return set;
}

}  // namespace diffsac
