// A COLMAP database.

#include <filesystem>

#include "diffsac/core/files.h"
#include "fuzz/fuzz_target.h"
#include "lab/files/colmap_lens.h"
#include "lab/files/colmap_test_util.h"

namespace diffsac::testing {

std::vector<std::string> Seeds() {
  std::filesystem::remove(Scratch() + "/seed.db");
  const std::string path = Scratch() + "/seed.db";
  {
    DatabaseMaker maker(path);
    // As small as SQLite's pages get, so that a change more often meets what is read.
    maker.Run("PRAGMA page_size = 512");
    maker.Run("VACUUM");
    maker.AddCamera(1, 2, {500, 320, 240, 0.1});
    maker.AddImage(1, "a.jpg");
    maker.AddImage(2, "b.jpg");
    for (const int image : {1, 2}) maker.AddKeypoints(image, PointMatrix::Ones(4, 2), 2);
  }
  return {ReadFile(path)};
}

namespace {

void ReadAll(const std::string& path) {
  const ColmapDatabase database(path);
  PairNames(database);
  for (const auto& [id, image] : database.images()) {
    database.Keypoints(id);
    database.Descriptors(id);
    database.KeypointCount(id);
    const ColmapCamera& camera = database.CameraOf(id);
    Parses({path}, [&] { ColmapLens(camera, path).Undistort({3.0, 4.0}); });
  }
  for (const ColmapPair& pair : database.MatchedPairs()) database.Matches(pair);
}

}  // namespace
}  // namespace diffsac::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diffsac::testing;
  const std::string path = WriteScratch("fuzz.db", {reinterpret_cast<const char*>(data), size});
  Parses({path}, [&] { ReadAll(path); });
  return 0;
}
