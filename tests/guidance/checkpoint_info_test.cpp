#include "diffsac/guidance/engine/checkpoint_info.h"

#include <catch2/catch.hpp>

#include "core/errors.h"
#include "core/temporary_folder.h"
#include "diffsac/core/safetensors.h"
#include "diffsac/core/status.h"

namespace diffsac {

TEST_CASE("a checkpoint whose configuration asks for far more weights than it holds is refused") {
  const TemporaryFolder folder;
  const std::string path = folder.File("small.safetensors");
  SafetensorsWriter writer;
  WriteInfo({.method = "diffsac", .task = "line", .config = "", .git_revision = ""}, &writer);
  const std::vector<float> weights(6, 1.0f);
  writer.Add("average.a", {2, 3}, weights);
  writer.Add("network.a", {2, 3}, weights);
  WriteRaw(path, writer.Content());
  RequireWeights(path, 6);
  CHECK_THROWS_WITH(RequireWeights(path, 7),
                    Catch::Contains("small.safetensors: its configuration asks for a network of at least 7 weights"));
  CHECK_THROWS_AS(RequireWeights(path, std::int64_t{128} * 4096 * 4096), Error);
}

}  // namespace diffsac
