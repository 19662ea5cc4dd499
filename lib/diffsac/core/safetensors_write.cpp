#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>

#include "diffsac/core/safetensors.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

std::string BytesOf(std::uint64_t value) {
  static_assert(std::endian::native == std::endian::little);
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

template <class T>
std::string BytesOf(std::span<const T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

}  // namespace

void SafetensorsWriter::Add(const std::string& name, const std::vector<std::int64_t>& shape,
                            std::span<const float> values) {
  AddBytes(name, {"F32", shape, BytesOf(values)});
}

void SafetensorsWriter::Add(const std::string& name, const std::vector<std::int64_t>& shape,
                            std::span<const std::int64_t> values) {
  AddBytes(name, {"I64", shape, BytesOf(values)});
}

void SafetensorsWriter::AddBytes(const std::string& name, Tensor tensor) {
  std::uint64_t bytes = ElementSize(tensor.type);
  for (const std::int64_t size : tensor.shape) bytes *= static_cast<std::uint64_t>(size);
  if (bytes != tensor.bytes.size()) throw std::logic_error("tensor '" + name + "': values that are not of its shape");
  tensors_[name] = std::move(tensor);
}

std::string SafetensorsWriter::Content() const {
  // The widest elements first, so that each tensor is aligned where the file is mapped.
  std::vector<const std::pair<const std::string, Tensor>*> order;
  for (const auto& item : tensors_) order.push_back(&item);
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
    return ElementSize(a->second.type) > ElementSize(b->second.type);
  });
  nlohmann::json header = {{"__metadata__", metadata_}};
  std::string data;
  for (const auto* item : order) {
    const auto& [name, tensor] = *item;
    const std::size_t begin = data.size();
    data += tensor.bytes;
    header[name] = {{"dtype", tensor.type}, {"shape", tensor.shape}, {"data_offsets", {begin, data.size()}}};
  }
  std::string text;
  try {
    text = header.dump();
  } catch (const nlohmann::json::exception&) {
    throw Error("a name or text of a safetensors file is not UTF-8");
  }
  text.resize((text.size() + 7) / 8 * 8, ' ');
  return BytesOf(text.size()) + text + data;
}

}  // namespace diffsac
