#include "diffsac/core/safetensors.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>
#include <string>

#include "core/errors.h"
#include "core/temporary_folder.h"
#include "diffsac/core/status.h"

namespace {
std::atomic<std::size_t> largest_request{0};  // of C++ memory, in bytes, since it was set to 0
}

// In place of the library's, for the whole test program.
void* operator new(std::size_t size) {
  for (std::size_t seen = largest_request; size > seen && !largest_request.compare_exchange_weak(seen, size);) {
  }
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace diffsac {
namespace {

using Catch::Contains;

std::string Length(std::uint64_t value) { return {reinterpret_cast<const char*>(&value), sizeof value}; }

// A file of this header and so many bytes of data.
std::string File(const std::string& header, std::size_t data = 0) {
  return Length(header.size()) + header + std::string(data, '\1');
}

std::string Tensor(const std::string& name, const std::string& type, const std::string& shape,
                   const std::string& offsets) {
  return "\"" + name + "\":{\"dtype\":\"" + type + "\",\"shape\":" + shape + ",\"data_offsets\":" + offsets + "}";
}

std::string ErrorOf(const std::string& content) {
  const TemporaryFolder folder;
  WriteRaw(folder.File("x.safetensors"), content);
  return diffsac::ErrorOf([&] { SafetensorsFile file(folder.File("x.safetensors")); });
}

SafetensorsWriter Example() {
  SafetensorsWriter writer;
  const float values[] = {1.5f, -2, std::numeric_limits<float>::infinity(), 4, 5, -0.0f};
  const std::int64_t step = -7;
  writer.Add("a.weight", {2, 3}, values);
  writer.Add("empty", {0, 4}, std::span<const float>());
  writer.Add("step", {}, std::span<const std::int64_t>(&step, 1));
  writer.AddText("config", "name: \"x\"\nβ: 1\n");
  return writer;
}

}  // namespace

TEST_CASE("safetensors: what was written is read") {
  const TemporaryFolder folder;
  const std::string path = folder.File("a.safetensors");
  WriteRaw(path, Example().Content());
  SafetensorsFile file(path);
  CHECK(file.tensors().size() == 3);
  CHECK(file.Text("config") == "name: \"x\"\nβ: 1\n");
  std::vector<float> values(6);
  file.Read("a.weight", {2, 3}, values);
  CHECK(values[0] == 1.5f);
  CHECK(values[2] == std::numeric_limits<float>::infinity());
  CHECK(std::signbit(values[5]));
  std::int64_t step = 0;
  file.Read("step", {}, std::span(&step, 1));
  CHECK(step == -7);
  file.Read("empty", {0, 4}, std::span<float>());
}

TEST_CASE("safetensors: the bytes are those of the format, and of the content alone") {
  const std::string content = Example().Content();
  const std::string header =
      R"({"__metadata__":{"config":"name: \"x\"\nβ: 1\n"},"a.weight":{"data_offsets":[8,32],"dtype":"F32","shape":[2,3]},)"
      R"("empty":{"data_offsets":[32,32],"dtype":"F32","shape":[0,4]},"step":{"data_offsets":[0,8],"dtype":"I64","shape":[]}})";
  CHECK(content.substr(8).starts_with(header));
  CHECK(content.substr(0, 8) == Length((header.size() + 7) / 8 * 8));
  CHECK(content.size() % 8 == 0);

  SafetensorsWriter second;  // the same in another order
  const std::int64_t step = -7;
  second.AddText("config", "name: \"x\"\nβ: 1\n");
  second.Add("step", {}, std::span<const std::int64_t>(&step, 1));
  second.Add("empty", {0, 4}, std::span<const float>());
  const float values[] = {1.5f, -2, std::numeric_limits<float>::infinity(), 4, 5, -0.0f};
  second.Add("a.weight", {2, 3}, values);
  CHECK(second.Content() == content);
}

TEST_CASE("safetensors: a tensor that is not what is asked for is named") {
  const TemporaryFolder folder;
  const std::string path = folder.File("a.safetensors");
  WriteRaw(path, Example().Content());
  SafetensorsFile file(path);
  std::vector<float> values(6);
  CHECK_THROWS_WITH(file.Read("b", {6}, values), Contains("a.safetensors: tensor 'b' is missing"));
  CHECK_THROWS_WITH(file.Read("a.weight", {6}, values), Contains("'a.weight' is [2, 3], expected [6]"));
  CHECK_THROWS_WITH(file.Read("step", {}, std::span(values).first(1)), Contains("'step' is of I64, expected F32"));
  CHECK_THROWS_WITH(file.Text("task"), Contains("a.safetensors: its metadata has no 'task'"));
  SafetensorsWriter latin;
  latin.AddText("config", "caf\xe9");
  CHECK_THROWS_WITH(WriteRaw(path, latin.Content()), Contains("UTF-8"));
  CHECK(SafetensorsFile(path).tensors().size() == 3);
}

TEST_CASE("safetensors: a file that is none is refused with its reason") {
  struct Case {
    const char* name;
    std::string content, message;
  };
  const std::string one = Tensor("w", "F32", "[2]", "[0,8]");
  const std::string largest = "9223372036854775807", beyond = "9223372036854775808";
  const std::vector<Case> cases = {
      {"empty", "", "it has 0 bytes"},
      {"cut in its length", File("{}").substr(0, 5), "it has 5 bytes"},
      {"no header", Length(2), "its header would have 2 bytes"},
      {"cut in its header", File("{" + one + "}", 8).substr(0, 30), "its header would have"},
      {"cut in its data", File("{" + one + "}", 7), "0 to 8 are not within the data of 7 bytes"},
      {"data cut away", File("{" + one + "}"), "not within the data of 0 bytes"},
      {"length 2^63", Length(std::uint64_t{1} << 63) + "{}", "9223372036854775808 bytes, the file has 10"},
      {"length 2^64 - 1", Length(~std::uint64_t{0}) + "{}", "18446744073709551615 bytes"},
      {"a long header", File("{" + std::string((4u << 20) + 1, ' ') + "}"), "expected at most 4194304"},
      {"a zip archive", "PK\3\4 and more of an archive", "a zip archive"},
      {"HDF5", "\211HDF\r\n\032\n and more", "an HDF5 file"},
      {"no JSON", File("{]"), "no JSON from its byte 2 on"},
      {"a list", File("[]"), "no JSON map"},
      {"a byte order mark", File("\xef\xbb\xbf{}"), "no JSON map"},
      {"not UTF-8", File("{\"\xe9\":1}"), "no JSON from its byte"},
      {"two documents", File("{} {}"), "no JSON from its byte"},
      {"a comment", File("{} // x"), "no JSON from its byte"},
      {"a zero byte", File(std::string("{}\0", 3)), "no zero byte"},
      {"cut JSON", File("{\"w\":"), "no JSON from its byte"},
      {"an endless number", File("{\"w\":1e999}"), "no JSON"},
      {"deep", File("{\"w\":" + std::string(100000, '[')), "nested deeper"},
      {"deep maps", File("{\"w\":{\"a\":{\"b\":{\"c\":1}}}}"), "nested deeper"},
      {"a tensor twice", File("{" + one + "," + one + "}", 8), "the key 'w' twice"},
      {"a key twice", File(R"({"w":{"dtype":"F32","dtype":"F32","shape":[],"data_offsets":[0,4]}})", 4),
       "the key 'dtype' twice"},
      {"metadata twice", File(R"({"__metadata__":{},"__metadata__":{}})"), "the key '__metadata__' twice"},
      {"metadata of numbers", File(R"({"__metadata__":{"a":1}})"), "its metadata 'a': expected a text"},
      {"metadata that is no map", File(R"({"__metadata__":["a"]})"), "its __metadata__: expected a map"},
      {"no tensor", File("{\"w\":3}"), "tensor 'w': expected a map of dtype, shape and data_offsets"},
      {"a key missing", File(R"({"w":{"dtype":"F32","shape":[]}})"), "expected a map of dtype, shape"},
      {"a key more", File(R"({"w":{"dtype":"F32","shape":[],"data_offsets":[0,4],"x":0}})", 4), "expected a map of"},
      {"dtype 7", File(R"({"w":{"dtype":7,"shape":[],"data_offsets":[0,4]}})", 4), "dtype: expected a text"},
      {"unknown dtype", File("{" + Tensor("w", "F33", "[1]", "[0,4]") + "}", 4), "unknown dtype 'F33'"},
      {"no shape", File("{" + Tensor("w", "F32", "{}", "[0,4]") + "}", 4), "shape: expected a list"},
      {"a negative size", File("{" + Tensor("w", "F32", "[-1]", "[0,4]") + "}", 4), "shape: expected whole numbers"},
      {"half a size", File("{" + Tensor("w", "F32", "[0.5]", "[0,4]") + "}", 4), "shape: expected whole numbers"},
      {"a size as text", File("{" + Tensor("w", "F32", "[\"1\"]", "[0,4]") + "}", 4), "shape: expected whole"},
      {"a size of 2^63", File("{" + Tensor("w", "F32", "[" + beyond + "]", "[0,4]") + "}", 4), "expected whole"},
      {"bytes overflow", File("{" + Tensor("w", "F32", "[" + largest + "]", "[0,4]") + "}", 4), "can be counted"},
      {"a product of 2^64", File("{" + Tensor("w", "U8", "[4294967296,4294967296]", "[0,0]") + "}"), "can be counted"},
      {"it overflows before a 0", File("{" + Tensor("w", "F32", "[" + largest + ",4,0]", "[0,0]") + "}"), "counted"},
      {"one offset", File("{" + Tensor("w", "F32", "[1]", "[4]") + "}", 4), "data_offsets: expected two numbers"},
      {"offsets backwards", File("{" + Tensor("w", "F32", "[1]", "[4,0]") + "}", 4), "not within the data"},
      {"far offsets", File("{" + Tensor("w", "F32", "[1]", "[" + largest + "," + largest + "]") + "}", 4), "within"},
      {"too few bytes", File("{" + Tensor("w", "F32", "[2]", "[0,4]") + "}", 4), "are not the 8 bytes of its dtype"},
      {"a claim of 2^42", File("{" + Tensor("w", "F32", "[1099511627776]", "[0,4]") + "}", 4), "not the 4398046511104"},
      {"overlap", File("{" + one + "," + Tensor("v", "F32", "[2]", "[4,12]") + "}", 12), "'v' overlaps another"},
      {"the same bytes", File("{" + one + "," + Tensor("v", "F32", "[2]", "[0,8]") + "}", 8), "overlaps another"},
      {"a hole", File("{" + one + "," + Tensor("v", "F32", "[1]", "[12,16]") + "}", 16), "8 to 12 belong to no tensor"},
      {"a hole first", File("{" + Tensor("w", "F32", "[1]", "[4,8]") + "}", 8), "0 to 4 belong to no tensor"},
      {"more data", File("{" + one + "}", 9), "have 8 bytes, 9 follow"},
      {"data without tensors", File("{}", 1), "have 0 bytes, 1 follow"},
      {"a name for the terminal", File("{\"\\u001b[2J\\n" + std::string(200, 'x') + "\":3}"), "tensor '?[2J?xxx"}};
  for (const Case& c : cases) {
    INFO(c.name);
    largest_request = 0;
    const std::string message = ErrorOf(c.content);
    CHECK(largest_request <= std::max<std::size_t>(2 * c.content.size(), 1 << 17));
    CHECK_THAT(message, Contains("x.safetensors: not a safetensors file: ") && Contains(c.message));
    CHECK(message.find('\n') == std::string::npos);
    CHECK(message.size() < 400);
  }
  CHECK(ErrorOf(File("{" + one + "}   ", 8)).empty());
  CHECK(ErrorOf(File("{}")).empty());
}

TEST_CASE("safetensors: every file that is cut or has a byte more is refused") {
  const std::string content = Example().Content();
  for (std::size_t size = 0; size < content.size(); ++size) {
    INFO(size);
    CHECK_FALSE(ErrorOf(content.substr(0, size)).empty());
  }
  CHECK_FALSE(ErrorOf(content + "x").empty());
}

TEST_CASE("safetensors: what is no file is refused") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(SafetensorsFile(folder.File("none")), Contains("none: no such file"));
  CHECK_THROWS_WITH(SafetensorsFile(folder.path()), Contains("not a file"));
  CHECK_THROWS_AS(SafetensorsFile("/dev/zero"), Error);
}

}  // namespace diffsac
