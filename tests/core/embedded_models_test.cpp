#include "diffsac/core/embedded_models.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/errors.h"
#include "diffsac/core/safetensors.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

const std::string kModels = std::string(DIFFSAC_SOURCE_DIR) + "/models";

std::string BytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST_CASE("embedded networks equal their files") {
  int embedded = 0;
  for (const fs::directory_entry& folder : fs::directory_iterator(kModels)) {
    const std::string name = folder.path().filename().string() + "/model.safetensors";
    const std::string_view bytes = EmbeddedModel(ModelPlace(name));
    if (bytes.empty()) continue;
    ++embedded;
    CAPTURE(name);
    CHECK(bytes == BytesOf(ModelPlace(name, kModels)));
    const SafetensorsFile file(name, bytes), same(ModelPlace(name, kModels));
    CHECK(file.Text("config") == same.Text("config"));
  }
  CHECK(embedded == 9);
  CHECK(EmbeddedModel(ModelPlace("essential/model.safetensors", kModels)).empty());
  CHECK(EmbeddedModel(ModelPlace("none/model.safetensors")).empty());
}

TEST_CASE("a damaged network in memory is refused") {
  const std::string_view whole = EmbeddedModel(ModelPlace("line/model.safetensors"));
  const auto error_of = [](std::string_view bytes) {
    return ErrorOf([&] { const SafetensorsFile file("some network", bytes); });
  };
  CHECK(error_of(whole).empty());
  CHECK(Has(error_of(whole.substr(0, 4)), "some network: not a safetensors file: it has 4 bytes"));
  CHECK(Has(error_of(whole.substr(0, 4000)), "some network: not a safetensors file: its header would have"));
  CHECK(Has(error_of(whole.substr(0, whole.size() - 1)), "some network: not a safetensors file:"));
}

}  // namespace diffsac
