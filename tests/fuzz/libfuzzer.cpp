// The targets under libFuzzer: the environment's DIFFSAC_FUZZ_TARGET names one.

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "fuzz/fuzz_target.h"

namespace {

const diffsac::testing::FuzzTarget& Target() {
  static const char* name = std::getenv("DIFFSAC_FUZZ_TARGET");
  const auto& targets = diffsac::testing::FuzzTargets();
  const auto found = targets.find(name == nullptr ? "" : name);
  diffsac::testing::Require(found != targets.end(), "DIFFSAC_FUZZ_TARGET names a target");
  return found->second;
}

// libFuzzer's first folder, where it is empty, is filled with the target's seeds.
void FillCorpus(int argc, char** argv) {
  namespace fs = std::filesystem;
  for (int i = 1; i < argc; ++i) {
    if (argv[i][0] == '-') continue;
    std::error_code code;
    if (!fs::is_directory(argv[i], code) || !fs::is_empty(argv[i], code)) return;
    int number = 0;
    for (const std::string& seed : Target().seeds())
      std::ofstream(fs::path(argv[i]) / ("seed-" + std::to_string(number++)), std::ios::binary)
          .write(seed.data(), static_cast<std::streamsize>(seed.size()));
    return;
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  FillCorpus(*argc, *argv);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Target().run(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
