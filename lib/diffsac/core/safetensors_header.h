#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace diffsac {

/// What a safetensors file says of one tensor: row-major, little-endian, in the bytes [begin, end) of the data.
struct TensorInfo {
  std::string type;  ///< The format's name of its elements: "F32", "I64", ...
  std::vector<std::int64_t> shape;
  std::uint64_t begin = 0, end = 0;
};

struct SafetensorsHeader {
  std::map<std::string, std::string> metadata;
  std::map<std::string, TensorInfo> tensors;
};

/// Bytes of one element; 0 for a type that the format does not have.
std::uint64_t ElementSize(std::string_view type);

/// Parses the JSON of a header that is followed by `data_size` bytes, and checks that each tensor's bytes are as many
/// as its type and shape ask for and that all tensors cover the data once. Nothing that the header merely claims is
/// allocated. Throws Error that begins with `path`.
SafetensorsHeader ParseSafetensorsHeader(std::string_view text, std::uint64_t data_size, const std::string& path);

/// A name or text of a file for a message: quoted, on one line, without control characters, cut where it is long.
std::string Shown(const std::string& text);

/// "[2, 3]"
std::string ShapeText(const std::vector<std::int64_t>& shape);

}  // namespace diffsac
