#include "lab/images/numpy_file.h"

#include <zip.h>

#include <charconv>
#include <cstdint>
#include <cstring>
#include <memory>
#include <regex>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/files/text_scan.h"

namespace diffsac {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::size_t kMostValues = 100'000'000;
// NumPy's have 118 bytes. Longer ones could exhaust the stack, which std::regex takes in proportion.
constexpr std::size_t kLongestHeader = 4096;
// What deflate makes of equal bytes.
constexpr zip_uint64_t kDensest = 1032;

template <class Number>
std::vector<double> Convert(std::string_view bytes) {
  std::vector<double> values(bytes.size() / sizeof(Number));
  for (std::size_t i = 0; i < values.size(); ++i) {
    Number number;
    std::memcpy(&number, bytes.data() + i * sizeof(Number), sizeof(Number));
    values[i] = static_cast<double>(number);
  }
  return values;
}

struct Type {
  const char* name;
  std::size_t size;
  std::vector<double> (*convert)(std::string_view);
};

constexpr Type kTypes[] = {
    {"<f8", 8, Convert<double>},       {"<f4", 4, Convert<float>},         {"<i8", 8, Convert<std::int64_t>},
    {"<i4", 4, Convert<std::int32_t>}, {"<u4", 4, Convert<std::uint32_t>}, {"<u8", 8, Convert<std::uint64_t>},
    {"|u1", 1, Convert<std::uint8_t>},
};

std::string Entry(const std::string& header, const std::string& pattern, const std::string& place) {
  std::smatch found;
  if (!std::regex_search(header, found, std::regex(pattern))) throw Error(place + ": not a header of NumPy's");
  return found[1];
}

std::vector<std::size_t> Shape(const std::string& text, const std::string& place) {
  std::vector<std::size_t> shape;
  for (const std::string_view word : SplitWords(text, ", ")) {
    const auto read = std::from_chars(word.data(), word.data() + word.size(), shape.emplace_back());
    if (read.ec != std::errc() || read.ptr != word.data() + word.size())
      throw Error(place + ": expected a shape, found '" + text + "'");
  }
  return shape;
}

// Row-major from column-major.
std::vector<double> Transposed(const std::vector<double>& values, const std::vector<std::size_t>& shape) {
  std::vector<double> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::size_t rest = i, place = 0;
    for (std::size_t d = 0; d < shape.size(); ++d) {
      std::size_t stride = 1;
      for (std::size_t e = d + 1; e < shape.size(); ++e) stride *= shape[e];
      place += rest % shape[d] * stride;
      rest /= shape[d];
    }
    result[place] = values[i];
  }
  return result;
}

// The header's text, and where the numbers begin.
std::string Header(std::string_view content, const std::string& place, std::size_t* begin) {
  if (!content.starts_with(kMagic) || content.size() < 12) throw Error(place + ": not a file of NumPy's");
  const auto byte = [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(content[i])); };
  const bool wide = content[6] > 1;
  const std::size_t start = wide ? 12 : 10;
  const std::size_t size = byte(8) + (byte(9) << 8) + (wide ? (byte(10) << 16) + (byte(11) << 24) : 0);
  if (content.size() < start + size) throw Error(place + ": truncated");
  if (size > kLongestHeader)
    throw Error(place + ": not a header of NumPy's: it would have " + std::to_string(size) + " bytes");
  *begin = start + size;
  return std::string(content.substr(start, size));
}

}  // namespace

NumpyArray ParseNpy(std::string_view content, const std::string& place) {
  std::size_t begin = 0;
  const std::string header = Header(content, place, &begin);
  const std::string name = Entry(header, "'descr': *'([^']*)'", place);
  const bool fortran = Entry(header, "'fortran_order': *(True|False)", place) == "True";
  NumpyArray array;
  array.shape = Shape(Entry(header, "'shape': *\\(([0-9, ]*)\\)", place), place);
  std::size_t count = 1;
  for (const std::size_t size : array.shape) {
    if (size > kMostValues || count * size > kMostValues) throw Error(place + ": too large");
    count *= size;
  }
  for (const Type& type : kTypes) {
    if (name != type.name) continue;
    if (content.size() - begin != count * type.size) throw Error(place + ": truncated");
    array.values = type.convert(content.substr(begin));
    if (fortran) array.values = Transposed(array.values, array.shape);
    return array;
  }
  throw Error(place + ": numbers of type " + name + " are not read");
}

NumpyArray ReadNpy(const std::string& path) { return ParseNpy(ReadFile(path), path); }

std::map<std::string, NumpyArray> ReadNpz(const std::string& path) {
  const std::string content = ReadFile(path);
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* source = zip_source_buffer_create(content.data(), content.size(), 0, &error);
  const std::unique_ptr<zip_t, void (*)(zip_t*)> archive(
      source != nullptr ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr, [](zip_t* z) { zip_discard(z); });
  if (!archive) {
    if (source != nullptr) zip_source_free(source);
    throw Error(path + ": not an archive: " + zip_error_strerror(&error));
  }
  std::map<std::string, NumpyArray> arrays;
  for (zip_int64_t i = 0; i < zip_get_num_entries(archive.get(), 0); ++i) {
    zip_stat_t entry;
    if (zip_stat_index(archive.get(), static_cast<zip_uint64_t>(i), 0, &entry) != 0) throw Error(path + ": broken");
    if (entry.name == nullptr) throw Error(path + ": an entry without a name");
    std::string name = entry.name;
    const std::string place = path + ": " + name;
    if (entry.size > 8 * kMostValues || entry.size / kDensest > content.size())
      throw Error(place + ": too large, or damaged");
    std::string bytes(entry.size, '\0');
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(
        zip_fopen_index(archive.get(), static_cast<zip_uint64_t>(i), 0), zip_fclose);
    if (!file || zip_fread(file.get(), bytes.data(), bytes.size()) != static_cast<zip_int64_t>(bytes.size()))
      throw Error(place + ": broken or truncated");
    if (name.ends_with(".npy")) name.resize(name.size() - 4);
    arrays[name] = ParseNpy(bytes, place);
  }
  return arrays;
}

}  // namespace diffsac
