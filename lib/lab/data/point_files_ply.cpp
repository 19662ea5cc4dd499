#include <algorithm>
#include <array>
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

enum class Encoding { kAscii, kLittleEndian, kBigEndian };

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
  std::string name;
  const Scalar* type = nullptr;
  const Scalar* list_count = nullptr;  // the type of the list's length; null for a single value
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::kAscii;
  std::vector<Element> elements;
};

// Reads the header line by line; what is left of the text is the data.
class HeaderReader {
 public:
  HeaderReader(const std::string& path, std::string_view text) : path_(path), rest_(text) {}

  Header Read() {
    std::string_view line = NextLine();
    if (line != "ply") Fail("not a PLY file: expected 'ply' in the first line");
    bool has_format = false;
    for (;;) {
      line = NextLine();
      const auto words = SplitWords(line, " \t");
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format") {
        ReadFormat(words);
        has_format = true;
      } else if (words[0] == "element") {
        ReadElement(words);
      } else if (words[0] == "property") {
        ReadProperty(words);
      } else {
        Fail("unknown PLY header line '" + std::string(line.substr(0, 60)) + "'");
      }
    }
    if (!has_format) Fail("PLY header without a format line");
    return std::move(header_);
  }

  std::string_view rest() const { return rest_; }
  int line() const { return line_; }

 private:
  using Words = std::vector<std::string_view>;

  [[noreturn]] void Fail(const std::string& message) const {
    throw Error(path_ + ":" + std::to_string(line_) + ": " + message);
  }

  std::string_view NextLine() {
    std::string_view line;
    ++line_;
    if (!TakeLine(&rest_, &line)) Fail("truncated PLY header: no end_header");
    return line;
  }

  void ReadFormat(const Words& words) {
    const std::string_view name = words.size() > 1 ? words[1] : "";
    if (name == "ascii") {
      header_.encoding = Encoding::kAscii;
    } else if (name == "binary_little_endian") {
      header_.encoding = Encoding::kLittleEndian;
    } else if (name == "binary_big_endian") {
      header_.encoding = Encoding::kBigEndian;
    } else {
      Fail("unknown PLY format '" + std::string(name) + "': expected ascii, binary_little_endian or binary_big_endian");
    }
  }

  void ReadElement(const Words& words) {
    Element element;
    if (words.size() == 3) {
      element.name = words[1];
      const auto result = std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
      if (result.ec == std::errc() && result.ptr == words[2].data() + words[2].size()) {
        header_.elements.push_back(std::move(element));
        return;
      }
    }
    Fail("expected 'element <name> <count>'");
  }

  const Scalar* TypeOf(std::string_view word) const {
    for (const Scalar& type : kScalars)
      if (word == type.name || word == type.other_name) return &type;
    Fail("unknown PLY type '" + std::string(word) + "'");
  }

  void ReadProperty(const Words& words) {
    if (header_.elements.empty()) Fail("PLY property before any element");
    const bool list = words.size() == 5 && words[1] == "list";
    if (!list && words.size() != 3) Fail("expected 'property <type> <name>' or 'property list <type> <type> <name>'");
    Property property;
    property.name = words.back();
    property.type = TypeOf(words[words.size() - 2]);
    if (list) property.list_count = TypeOf(words[2]);
    header_.elements.back().properties.push_back(std::move(property));
  }

  std::string path_;
  std::string_view rest_;
  int line_ = 0;
  Header header_;
};

// Reads one value after another.
class ValueReader {
 public:
  ValueReader(const std::string& path, Encoding encoding, std::string_view data, int line)
      : path_(path), encoding_(encoding), data_(data), line_(line) {}

  /// `what` stands in messages.
  double Read(const Scalar& type, const std::string& what) {
    return encoding_ == Encoding::kAscii ? ReadWord(what) : ReadBinary(type, what);
  }

  std::size_t left() const { return data_.size(); }

  /// In text a row is a line: of fewer or more values than its element has, all that follow would be another's.
  void BeginRow() { in_row_ = false; }
  void EndRow(const std::string& what) const {
    const std::size_t next = data_.find_first_not_of(" \t\r");
    if (encoding_ == Encoding::kAscii && in_row_ && next != std::string_view::npos && data_[next] != '\n')
      FailAt(what + " has more values than the header says");
  }

  /// How many more lines with something in them there are.
  std::uint64_t LinesLeft() const {
    std::string_view rest = data_, line;
    std::uint64_t count = 0;
    while (TakeLine(&rest, &line)) count += line.find_first_not_of(" \t\r") != std::string_view::npos ? 1 : 0;
    return count;
  }

 private:
  [[noreturn]] void FailAt(const std::string& problem) const {
    throw Error(path_ + ":" + std::to_string(line_ + 1) + ": " + problem);
  }

  double ReadWord(const std::string& what) {
    std::size_t start = 0;
    bool ended = false;
    while (start < data_.size() && std::string_view(" \t\r\n").find(data_[start]) != std::string_view::npos)
      ended = data_[start++] == '\n' || ended;
    if (start == data_.size()) throw Error(path_ + ": truncated: the file ends at " + what);
    if (ended && in_row_) FailAt(what + " has fewer values than the header says");
    line_ += static_cast<int>(std::count(data_.begin(), data_.begin() + static_cast<std::ptrdiff_t>(start), '\n'));
    data_.remove_prefix(start);
    in_row_ = true;
    const std::size_t end = std::min(data_.find_first_of(" \t\r\n"), data_.size());
    double value = 0.0;
    if (!ParseNumber(data_.substr(0, end), &value))
      FailAt("expected a number, found '" + std::string(data_.substr(0, std::min<std::size_t>(end, 40))) + "'");
    data_.remove_prefix(end);
    return value;
  }

  double ReadBinary(const Scalar& type, const std::string& what) {
    if (data_.size() < type.bytes) throw Error(path_ + ": truncated: the file ends at " + what);
    std::array<char, 8> bytes;
    std::copy_n(data_.begin(), type.bytes, bytes.begin());
    if (encoding_ == Encoding::kBigEndian) std::reverse(bytes.begin(), bytes.begin() + type.bytes);
    data_.remove_prefix(type.bytes);
    return type.value(bytes.data());
  }

  std::string path_;
  Encoding encoding_;
  std::string_view data_;
  int line_;  // of the lines before the current one
  bool in_row_ = false;
};

// The position of a property, -1 when absent. A coordinate cannot be a list.
int FindCoordinate(const std::string& path, const Element& element, const char* name) {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    if (element.properties[i].name != name) continue;
    if (element.properties[i].list_count) throw Error(path + ": the vertex property " + name + " is a list");
    return static_cast<int>(i);
  }
  return -1;
}

class PlyReader {
 public:
  PlyReader(const std::string& path, std::string_view text) : path_(path), header_reader_(path, text) {}

  PointMatrix Read() {
    const Header header = header_reader_.Read();
    ValueReader values(path_, header.encoding, header_reader_.rest(), header_reader_.line());
    for (std::size_t e = 0; e < header.elements.size(); ++e) {
      const Element& element = header.elements[e];
      if (element.name == "vertex") {
        PointMatrix points = ReadVertices(element, &values);
        WarnOfMore(header, e, values);
        return points;
      }
      if (element.properties.empty()) continue;
      for (std::uint64_t i = 0; i < element.count; ++i) ReadRow(element, i, &values);
    }
    throw Error(path_ + ": no element 'vertex' in this PLY file");
  }

 private:
  PointMatrix ReadVertices(const Element& element, ValueReader* values) {
    std::vector<int> columns;
    for (const char* name : {"x", "y", "z"}) {
      const int column = FindCoordinate(path_, element, name);
      if (column >= 0) columns.push_back(column);
      if (column < 0 && name[0] != 'z') throw Error(path_ + ": the element 'vertex' has no property " + name);
    }
    std::vector<double> flat;
    // A wrong count must not reserve more than the file can hold.
    flat.reserve(columns.size() * std::min<std::uint64_t>(element.count, values->left()));
    for (std::uint64_t i = 0; i < element.count; ++i) {
      ReadRow(element, i, values);
      for (int column : columns) flat.push_back(row_[column]);
    }
    const auto width = static_cast<Eigen::Index>(columns.size());
    return Eigen::Map<const PointMatrix>(flat.data(), static_cast<Eigen::Index>(element.count), width);
  }

  /// Of rows behind those that the header announces, where that can be told: in text each is a line; binary values
  /// are of the vertices where nothing else follows.
  void WarnOfMore(const Header& header, std::size_t vertex, const ValueReader& values) const {
    const std::vector<Element>& elements = header.elements;
    std::uint64_t left = 0, later = 0, row = 0;
    for (std::size_t i = vertex + 1; i < elements.size(); ++i) later += elements[i].count;
    if (header.encoding == Encoding::kAscii) {
      left = values.LinesLeft();
    } else if (later == 0) {
      for (const Property& property : elements[vertex].properties)
        row += property.list_count ? values.left() + 1 : property.type->bytes;
      left = values.left() / row;
    }
    if (left > later)
      WarnOnce(path_ + ": the header announces " + std::to_string(elements[vertex].count) +
               " points; left out: " + std::to_string(left - later) + " rows more");
  }

  // Fills row_ with the single values of one line of an element; lists are skipped.
  void ReadRow(const Element& element, std::uint64_t index, ValueReader* values) {
    const std::string what = element.name + " " + std::to_string(index + 1) + " of " + std::to_string(element.count);
    row_.assign(element.properties.size(), 0.0);
    values->BeginRow();
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      if (!property.list_count) {
        row_[p] = values->Read(*property.type, what);
        continue;
      }
      const double length = values->Read(*property.list_count, what);
      if (!(length >= 0.0)) throw Error(path_ + ": a list of negative length at " + what);
      for (double i = 0.0; i < length; ++i) values->Read(*property.type, what);
    }
    values->EndRow(what);
  }

  std::string path_;
  HeaderReader header_reader_;
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
