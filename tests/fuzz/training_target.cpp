// A whole configuration of diffsac_train, as the program reads it before it opens data.

#include "fuzz/fuzz_target.h"
#include "lab/config/yaml.h"
#include "lab/train/train_options.h"

namespace diffsac::testing {
namespace {

// The shipped networks' configurations stand as they were resolved.
std::vector<std::string> Seeds() { return FilesBelow(DIFFSAC_SOURCE_DIR "/models", "config.yaml", 6000); }

void Run(const std::string& text) {
  Parses({"fuzz.yaml"}, [&] {
    const auto read = ReadTrainConfig(ConfigFromYaml(text, "fuzz.yaml"));
    const std::string written = WriteTrainConfig(read);
    const auto again = ReadTrainConfig(ConfigFromYaml(written));
    Require(WriteTrainConfig(again) == written, "what is written reads back");
  });
}

const AddTarget kTraining{"training_config", Seeds, Run};

}  // namespace
}  // namespace diffsac::testing
