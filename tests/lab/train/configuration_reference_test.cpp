#include "lab/train/configuration_reference.h"

#include <catch2/catch.hpp>

#include "lab/files/files.h"

namespace diffsac {

TEST_CASE("docs/configuration.md is what the code describes") {
  INFO("cmake --build --preset release --target diffsac_reference writes it");
  const std::string head = ReadFile(DIFFSAC_SOURCE_DIR "/lib/lab/train/configuration_head.md");
  const bool current = ReadFile(DIFFSAC_SOURCE_DIR "/docs/configuration.md") == head + ConfigurationReference();
  CHECK(current);
}

TEST_CASE("Every key of the reference has a meaning") {
  const std::string text = ConfigurationReference();
  CHECK(text.size() < 40000);
  std::string without;
  for (std::size_t begin = 0, end = text.find('\n'); end != std::string::npos;
       begin = end + 1, end = text.find('\n', begin)) {
    const std::string line = text.substr(begin, end - begin);
    const std::size_t key = line.find("- `");
    const bool is_key = key == line.find_first_not_of(' ') && key != std::string::npos;
    if (is_key && line.find(": ", line.find('`', key + 3)) == std::string::npos) without += line + "\n";
  }
  CHECK(without == "");
}

}  // namespace diffsac
