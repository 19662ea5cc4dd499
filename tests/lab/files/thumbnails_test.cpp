#include "lab/files/thumbnails.h"

#include <catch2/catch.hpp>

#include "core/temporary_folder.h"
#include "diffsac/core/files.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

TEST_CASE("small copies come back byte for byte; what is not there is empty") {
  const TemporaryFolder folder;
  const std::string bytes("\xff\xd8\0 any bytes \xff", 14);
  WriteThumbnails(folder.path(), {"a", "none", "b"},
                  [&](std::size_t i) { return i == 1 ? std::string() : bytes + std::to_string(i); });
  CHECK(ReadThumbnail(folder.path(), "a") == bytes + "0");
  CHECK(ReadThumbnail(folder.path(), "b") == bytes + "2");
  CHECK(ReadThumbnail(folder.path(), "none").empty());
  CHECK(ReadThumbnail(folder.path(), "").empty());
  CHECK(ReadThumbnail(folder.File("nowhere"), "a").empty());
  WriteFileAtomically(folder.File(kThumbnailsFile), "no HDF5");
  CHECK_THROWS_WITH(ReadThumbnail(folder.path(), "a"), Catch::Contains("thumbnails.h5: a: damaged or truncated"));
}

}  // namespace
}  // namespace diffsac
