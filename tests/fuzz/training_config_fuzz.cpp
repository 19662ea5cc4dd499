// A whole configuration of diffsac_train, as the program reads it before it opens data.

#include <sstream>

#include "fuzz/fuzz_target.h"
#include "lab/config/yaml.h"
#include "lab/train/train_options.h"

namespace diffsac::testing {

std::vector<std::string> Seeds() {
  // The shipped networks' configurations stand as they were resolved.
  return FilesBelow(DIFFSAC_SOURCE_DIR "/models", "config.yaml", 6000);
}

}  // namespace diffsac::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diffsac::testing;
  const std::string text(reinterpret_cast<const char*>(data), size);
  Parses({"fuzz.yaml"}, [&] {
    const auto read = diffsac::ReadTrainConfig(diffsac::ConfigFromYaml(text, "fuzz.yaml"));
    const std::string written = diffsac::WriteTrainConfig(read);
    const auto again = diffsac::ReadTrainConfig(diffsac::ConfigFromYaml(written));
    Require(diffsac::WriteTrainConfig(again) == written, "what is written reads back");
  });
  return 0;
}
