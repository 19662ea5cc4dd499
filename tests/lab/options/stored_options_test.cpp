#include "diffsac/core/stored_options.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "diffsac/core/status.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
#include "diffsac/guidance/engine/network_options.h"
#include "diffsac/guidance/engine/set_scorer.h"
#include "lab/config/yaml.h"
#include "lab/options/config.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

StoredOptions Stored(const std::string& text) { return {text, "file"}; }

template <class Options>
void CheckSame(const Config& config, const Options& read) {
  CHECK(ToJson(ToConfig(ReadStoredOptions<Options>(config.Sub("network")))) == ToJson(ToConfig(read)));
}

TEST_CASE("stored options equal those of the tree") {
  int networks = 0;
  for (const auto& folder : std::filesystem::directory_iterator(DIFFSAC_SOURCE_DIR "/models")) {
    const std::string path = folder.path().string() + "/model.safetensors";
    if (!std::filesystem::exists(path)) continue;
    CAPTURE(path);
    const CheckpointInfo info = ReadCheckpointInfo(path);
    const Config config = CheckpointConfig(info, path);
    const StoredOptions network = StoredOptions(ConfigText(info, path), path).Sub("network");
    if (info.method == "diffsac") CheckSame(config, ReadNetworkOptions(network));
    if (info.method == "structure_chooser") CheckSame(config, ReadSetScorerOptions(network));
    ++networks;
  }
  CHECK(networks > 5);
}

TEST_CASE("stored options keep what is absent") {
  int number = 7;
  double share = 0.5;
  const StoredOptions stored = Stored(R"({"share": 1, "inner": {"number": 3}, "none": null})");
  stored.Read("number", &number, 0, 9);
  CHECK(number == 7);
  stored.Read("share", &share, 0.0, 1.0);
  CHECK(share == 1.0);
  stored.Sub("inner").Read("number", &number, 0, 9);
  CHECK(number == 3);
  CHECK_FALSE(stored.Has("none"));
  CHECK_FALSE(stored.Sub("absent").Has("number"));
}

TEST_CASE("wrong stored options name file and key") {
  using Catch::Contains;
  int number = 0;
  bool flag = false;
  std::string text;
  CHECK_THROWS_WITH(Stored("[1]"), Contains("file") && Contains("an object"));
  CHECK_THROWS_WITH(Stored("{"), Contains("file"));
  const StoredOptions stored = Stored(R"({"inner": {"number": 12, "list": [], "text": "a"}})").Sub("inner");
  CHECK_THROWS_WITH(stored.Read("number", &number, 0, 9), Contains("file: inner.number: expected"));
  CHECK_THROWS_WITH(stored.Read("text", &number, 0, 9), Contains("inner.text"));
  CHECK_THROWS_WITH(stored.Read("text", &flag), Contains("true or false"));
  CHECK_THROWS_WITH(stored.Read("number", &text), Contains("a text"));
  CHECK_THROWS_WITH(stored.Sub("list"), Contains("inner.list: expected a map"));
  for (const char* network : {R"({"denoiser": {"width": 9}})", R"({"denoiser": {"kind": "mlpp"}})",
                              R"({"features": {"kinds": []}})", R"({"schedule": {"steps": 0}})"})
    CHECK_THROWS_AS(ReadNetworkOptions(Stored(network)), Error);
}

}  // namespace
}  // namespace diffsac
