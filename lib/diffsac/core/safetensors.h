#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "diffsac/core/safetensors_header.h"

namespace diffsac {

/// Reads a safetensors file: tensors by name, and texts about them. It holds data alone, so nothing of a file is ever
/// run. The header is checked whole before a tensor is read; then each tensor is read where it is wanted.
class SafetensorsFile {
 public:
  /// Throws Error naming the file and what is wrong when it is missing, of another format or damaged.
  explicit SafetensorsFile(std::string path);
  /// The same of a file in memory, which stays where it is. `path` names it in messages.
  SafetensorsFile(std::string path, std::string_view memory);

  const std::string& path() const { return path_; }
  const std::map<std::string, TensorInfo>& tensors() const { return header_.tensors; }

  bool HasText(const std::string& key) const { return header_.metadata.contains(key); }
  /// A text of the metadata. Throws Error when there is none.
  const std::string& Text(const std::string& key) const;

  /// Reads a tensor. Throws Error when it is absent or of another element type or shape; `values` has the shape's size.
  void Read(const std::string& name, const std::vector<std::int64_t>& shape, std::span<float> values);
  void Read(const std::string& name, const std::vector<std::int64_t>& shape, std::span<std::int64_t> values);

 private:
  void ReadHeader();
  void ReadBytes(const std::string& name, const std::string& type, const std::vector<std::int64_t>& shape,
                 std::span<std::byte> bytes);
  void ReadAt(std::uint64_t begin, std::span<std::byte> bytes, const std::string& where);
  [[noreturn]] void Fail(const std::string& what) const;

  std::string path_;
  std::ifstream stream_;  ///< Closed if the file is in memory.
  std::string_view memory_;
  std::uint64_t size_ = 0;
  std::uint64_t data_begin_ = 0;
  SafetensorsHeader header_;
};

/// Writes such a file. The same tensors and texts make the same bytes, in whatever order they were added.
class SafetensorsWriter {
 public:
  void AddText(const std::string& key, const std::string& text) { metadata_[key] = text; }
  void Add(const std::string& name, const std::vector<std::int64_t>& shape, std::span<const float> values);
  void Add(const std::string& name, const std::vector<std::int64_t>& shape, std::span<const std::int64_t> values);

  /// The whole file. Throws Error when a name or text is not UTF-8.
  std::string Content() const;

 private:
  struct Tensor {
    std::string type;
    std::vector<std::int64_t> shape;
    std::string bytes;
  };
  void AddBytes(const std::string& name, Tensor tensor);

  std::map<std::string, std::string> metadata_;
  std::map<std::string, Tensor> tensors_;
};

}  // namespace diffsac
