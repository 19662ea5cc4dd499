#include "diffsac/core/safetensors_header.h"

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>
#include <utility>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

using nlohmann::json;

// The header's map is at depth 0, a tensor's map at 1, its shape at 2.
constexpr int kDeepest = 2;
constexpr const char* kMetadataKey = "__metadata__";

class HeaderParser {
 public:
  HeaderParser(std::uint64_t data_size, const std::string& path) : data_size_(data_size), path_(path) {}

  SafetensorsHeader Parse(std::string_view text) {
    const json root = ParseJson(text);
    SafetensorsHeader header;
    for (const auto& [name, value] : root.items()) {
      if (name == kMetadataKey)
        header.metadata = ParseMetadata(value);
      else
        header.tensors[name] = ParseTensor(value, "tensor " + Shown(name));
    }
    CheckCover(header.tensors);
    return header;
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const { throw Error(path_ + ": not a safetensors file: " + what); }

  json ParseJson(std::string_view text) {
    // The parser would take a zero byte for the end of the text, and pass over a byte order mark.
    if (!text.starts_with('{') || text.find('\0') != std::string_view::npos)
      Fail("its header is no JSON map (it must begin with '{' and hold no zero byte)");
    try {
      return json::parse(text.begin(), text.end(), [this](int depth, json::parse_event_t event, json& parsed) {
        CheckEvent(depth, event, parsed);
        return true;
      });
    } catch (const json::parse_error& error) {
      Fail("its header is no JSON from its byte " + std::to_string(error.byte) + " on");
    } catch (const json::exception&) {
      Fail("its header is no JSON that can be read");
    }
  }

  // What the parsed document no longer shows, at the place where it appears.
  void CheckEvent(int depth, json::parse_event_t event, const json& parsed) {
    using Event = json::parse_event_t;
    const bool opens = event == Event::object_start || event == Event::array_start;
    if (opens && depth > kDeepest) Fail("its header is nested deeper than a tensor's shape");
    if (event == Event::object_start) keys_[depth].clear();
    if (event == Event::key && !keys_[depth - 1].insert(parsed.get<std::string>()).second)
      Fail("its header has the key " + Shown(parsed.get<std::string>()) + " twice");
  }

  std::map<std::string, std::string> ParseMetadata(const json& value) const {
    if (!value.is_object()) Fail("its __metadata__: expected a map of texts");
    std::map<std::string, std::string> metadata;
    for (const auto& [key, text] : value.items()) {
      if (!text.is_string()) Fail("its metadata " + Shown(key) + ": expected a text");
      metadata[key] = text.get<std::string>();
    }
    return metadata;
  }

  TensorInfo ParseTensor(const json& value, const std::string& where) const {
    const bool whole = value.is_object() && value.size() == 3 && value.contains("dtype") && value.contains("shape") &&
                       value.contains("data_offsets");
    if (!whole) Fail(where + ": expected a map of dtype, shape and data_offsets");
    if (!value["dtype"].is_string()) Fail(where + ": dtype: expected a text");
    TensorInfo tensor;
    tensor.type = value["dtype"].get<std::string>();
    tensor.shape = ParseSizes(value["shape"], where + ": shape");
    const auto offsets = ParseSizes(value["data_offsets"], where + ": data_offsets");
    if (offsets.size() != 2) Fail(where + ": data_offsets: expected two numbers");
    tensor.begin = static_cast<std::uint64_t>(offsets[0]);
    tensor.end = static_cast<std::uint64_t>(offsets[1]);
    CheckBytes(tensor, where);
    return tensor;
  }

  std::vector<std::int64_t> ParseSizes(const json& value, const std::string& where) const {
    constexpr std::uint64_t kLargest = std::numeric_limits<std::int64_t>::max();
    if (!value.is_array()) Fail(where + ": expected a list of whole numbers");
    std::vector<std::int64_t> sizes;
    for (const json& size : value) {
      if (!size.is_number_unsigned() || size.get<std::uint64_t>() > kLargest)
        Fail(where + ": expected whole numbers from 0 to 2^63 - 1");
      sizes.push_back(size.get<std::int64_t>());
    }
    return sizes;
  }

  void CheckBytes(const TensorInfo& tensor, const std::string& where) const {
    std::uint64_t bytes = ElementSize(tensor.type);
    if (bytes == 0) Fail(where + ": unknown dtype " + Shown(tensor.type));
    for (const std::int64_t size : tensor.shape)
      if (__builtin_mul_overflow(bytes, static_cast<std::uint64_t>(size), &bytes))
        Fail(where + ": its shape has more bytes than can be counted");
    const std::string place = " the bytes " + std::to_string(tensor.begin) + " to " + std::to_string(tensor.end);
    if (tensor.begin > tensor.end || tensor.end > data_size_)
      Fail(where + ":" + place + " are not within the data of " + std::to_string(data_size_) + " bytes");
    if (tensor.end - tensor.begin != bytes)
      Fail(where + ":" + place + " are not the " + std::to_string(bytes) + " bytes of its dtype and shape");
  }

  void CheckCover(const std::map<std::string, TensorInfo>& tensors) const {
    struct Part {
      std::uint64_t begin, end;
      const std::string* name;
    };
    std::vector<Part> parts;
    for (const auto& [name, tensor] : tensors) parts.push_back({tensor.begin, tensor.end, &name});
    std::sort(parts.begin(), parts.end(),
              [](const Part& a, const Part& b) { return std::tie(a.begin, a.end) < std::tie(b.begin, b.end); });
    std::uint64_t covered = 0;
    for (const Part& part : parts) {
      if (part.begin < covered) Fail("tensor " + Shown(*part.name) + " overlaps another");
      if (part.begin > covered)
        Fail("the bytes " + std::to_string(covered) + " to " + std::to_string(part.begin) + " belong to no tensor");
      covered = part.end;
    }
    if (covered != data_size_)
      Fail("its tensors have " + std::to_string(covered) + " bytes, " + std::to_string(data_size_) +
           " follow the header");
  }

  std::uint64_t data_size_;
  const std::string& path_;
  std::array<std::set<std::string>, kDeepest + 1> keys_;  // of the maps that are open, by depth
};

}  // namespace

std::uint64_t ElementSize(std::string_view type) {
  constexpr std::pair<std::string_view, std::uint64_t> kSizes[] = {
      {"BOOL", 1}, {"U8", 1},  {"I8", 1},  {"F8_E5M2", 1}, {"F8_E4M3", 1}, {"U16", 2}, {"I16", 2}, {"F16", 2},
      {"BF16", 2}, {"U32", 4}, {"I32", 4}, {"F32", 4},     {"U64", 8},     {"I64", 8}, {"F64", 8}};
  for (const auto& [name, size] : kSizes)
    if (name == type) return size;
  return 0;
}

SafetensorsHeader ParseSafetensorsHeader(std::string_view text, std::uint64_t data_size, const std::string& path) {
  return HeaderParser(data_size, path).Parse(text);
}

std::string Shown(const std::string& text) {
  constexpr std::size_t kLongest = 80;
  std::string shown;
  for (const char c : text.substr(0, kLongest)) shown += c >= ' ' && c <= '~' ? c : '?';
  return "'" + shown + (text.size() > kLongest ? "...'" : "'");
}

std::string ShapeText(const std::vector<std::int64_t>& shape) {
  std::string text;
  for (const std::int64_t size : shape) text += (text.empty() ? "" : ", ") + std::to_string(size);
  return "[" + text + "]";
}

}  // namespace diffsac
