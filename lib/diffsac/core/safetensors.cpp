#include "diffsac/core/safetensors.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

static_assert(std::endian::native == std::endian::little, "files are read and written as they lie in memory");

// Networks of ours need a hundredth of it.
constexpr std::uint64_t kLargestHeader = std::uint64_t{4} << 20;
constexpr std::uint64_t kLengthBytes = 8;

// What files that people may give by mistake begin with.
std::string OtherFormat(const char* first) {
  if (std::memcmp(first, "PK\3\4", 4) == 0)
    return "a zip archive, as older programs kept networks in, which could run code and is not read any more; "
           "train again, or use a shipped models/*/model.safetensors";
  if (std::memcmp(first, "\211HDF\r\n\032\n", 8) == 0) return "an HDF5 file";
  return "";
}

}  // namespace

SafetensorsFile::SafetensorsFile(std::string path) : path_(std::move(path)) {
  if (!std::filesystem::exists(path_)) throw Error(path_ + ": no such file");
  if (!std::filesystem::is_regular_file(path_)) throw Error(path_ + ": not a file");
  stream_.open(path_, std::ios::binary);
  if (!stream_) throw Error(path_ + ": cannot be opened");
  stream_.seekg(0, std::ios::end);
  size_ = static_cast<std::uint64_t>(std::max<std::streamoff>(stream_.tellg(), 0));
  ReadHeader();
}

SafetensorsFile::SafetensorsFile(std::string path, std::string_view memory)
    : path_(std::move(path)), memory_(memory), size_(memory.size()) {
  ReadHeader();
}

void SafetensorsFile::ReadAt(std::uint64_t begin, std::span<std::byte> bytes, const std::string& where) {
  if (!stream_.is_open()) {
    std::memcpy(bytes.data(), memory_.data() + begin, bytes.size());
    return;
  }
  stream_.seekg(static_cast<std::streamoff>(begin));
  stream_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!stream_) throw Error(where + " cannot be read");
}

void SafetensorsFile::Fail(const std::string& what) const { throw Error(path_ + ": not a safetensors file: " + what); }

void SafetensorsFile::ReadHeader() {
  if (size_ < kLengthBytes) Fail("it has " + std::to_string(size_) + " bytes, expected more");
  char first[kLengthBytes];
  ReadAt(0, std::as_writable_bytes(std::span(first)), path_ + ":");
  if (const std::string other = OtherFormat(first); !other.empty()) Fail(other);
  std::uint64_t length = 0;
  std::memcpy(&length, first, kLengthBytes);
  if (length > size_ - kLengthBytes)
    Fail("its header would have " + std::to_string(length) + " bytes, the file has " + std::to_string(size_));
  if (length > kLargestHeader)
    Fail("its header has " + std::to_string(length) + " bytes, expected at most " + std::to_string(kLargestHeader));
  std::string text(length, '\0');
  ReadAt(kLengthBytes, std::as_writable_bytes(std::span(text)), path_ + ":");
  data_begin_ = kLengthBytes + length;
  header_ = ParseSafetensorsHeader(text, size_ - data_begin_, path_);
}

const std::string& SafetensorsFile::Text(const std::string& key) const {
  const auto found = header_.metadata.find(key);
  if (found == header_.metadata.end()) throw Error(path_ + ": its metadata has no '" + key + "'");
  return found->second;
}

void SafetensorsFile::Read(const std::string& name, const std::vector<std::int64_t>& shape, std::span<float> values) {
  ReadBytes(name, "F32", shape, std::as_writable_bytes(values));
}

void SafetensorsFile::Read(const std::string& name, const std::vector<std::int64_t>& shape,
                           std::span<std::int64_t> values) {
  ReadBytes(name, "I64", shape, std::as_writable_bytes(values));
}

void SafetensorsFile::ReadBytes(const std::string& name, const std::string& type,
                                const std::vector<std::int64_t>& shape, std::span<std::byte> bytes) {
  const std::string where = path_ + ": tensor '" + name + "'";
  const auto found = header_.tensors.find(name);
  if (found == header_.tensors.end()) throw Error(where + " is missing");
  const TensorInfo& tensor = found->second;
  if (tensor.shape != shape) throw Error(where + " is " + ShapeText(tensor.shape) + ", expected " + ShapeText(shape));
  if (tensor.type != type) throw Error(where + " is of " + tensor.type + ", expected " + type);
  if (tensor.end - tensor.begin != bytes.size()) throw std::logic_error(where + ": no room for its values");
  ReadAt(data_begin_ + tensor.begin, bytes, where);
}

}  // namespace diffsac
