#include "lab/files/thumbnails.h"

#include <H5Cpp.h>

#include <catch2/catch.hpp>

#include "core/temporary_folder.h"

namespace diffsac {
namespace {

TEST_CASE("small copies are in the file byte for byte, empty ones are not") {
  const TemporaryFolder folder;
  const std::string bytes("\xff\xd8\0 any bytes \xff", 14);
  WriteThumbnails(folder.path(), {"a", "none", "b"},
                  [&](std::size_t i) { return i == 1 ? std::string() : bytes + std::to_string(i); });
  const H5::H5File file(folder.File(kThumbnailsFile), H5F_ACC_RDONLY);
  const auto read = [&](const char* image) {
    const H5::DataSet data = file.openDataSet(image);
    std::string content(static_cast<std::size_t>(data.getSpace().getSimpleExtentNpoints()), '\0');
    data.read(content.data(), H5::PredType::NATIVE_UINT8);
    return content;
  };
  CHECK(read("a") == bytes + "0");
  CHECK(read("b") == bytes + "2");
  CHECK_FALSE(file.nameExists("none"));
}

}  // namespace
}  // namespace diffsac
