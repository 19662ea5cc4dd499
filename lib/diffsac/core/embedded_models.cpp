#include "diffsac/core/embedded_models.h"

#include <filesystem>

// An assembler takes a file as it is, where a compiler needs minutes for an array of eight megabytes. The list has a
// DIFFSAC_MODEL(symbol, name, file) for each network (CMakeLists.txt).
#ifdef __APPLE__
#define DIFFSAC_SECTION "__TEXT,__const"
#define DIFFSAC_PREFIX "_"
#define DIFFSAC_HIDDEN ".private_extern "
#else
#define DIFFSAC_SECTION ".rodata"
#define DIFFSAC_PREFIX ""
#define DIFFSAC_HIDDEN ".hidden "
#endif
#define DIFFSAC_LABEL(name) \
  ".globl " DIFFSAC_PREFIX name "\n" DIFFSAC_HIDDEN DIFFSAC_PREFIX name "\n" DIFFSAC_PREFIX name ":\n"

#define DIFFSAC_MODEL(symbol, name, file)                                                              \
  asm(".pushsection " DIFFSAC_SECTION                                                                  \
      "\n.balign 16\n" DIFFSAC_LABEL("diffsac_model_" #symbol) ".incbin \"" file "\"\n" DIFFSAC_LABEL( \
          "diffsac_model_end_" #symbol) ".byte 0\n.popsection\n");                                     \
  extern "C" __attribute__((visibility("hidden"))) const char diffsac_model_##symbol[], diffsac_model_end_##symbol[];
#include "embedded_models.inc"
#undef DIFFSAC_MODEL

namespace diffsac {

std::string ModelPlace(const std::string& name, const std::string& folder) {
  return folder.empty() ? std::string(kEmbedded) + name : (std::filesystem::path(folder) / name).string();
}

std::string_view EmbeddedModel(std::string_view place) {
  if (!place.starts_with(kEmbedded)) return {};
  const std::string_view wanted = place.substr(kEmbedded.size());
#define DIFFSAC_MODEL(symbol, name, file) \
  if (wanted == name) return {diffsac_model_##symbol, diffsac_model_end_##symbol};
#include "embedded_models.inc"
#undef DIFFSAC_MODEL
  return {};
}

}  // namespace diffsac
