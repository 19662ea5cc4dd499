#pragma once

#include <string>
#include <vector>

#include "lab/options/options.h"

namespace diffsac {

/// The options that the key `type` chose, with that key beside them, and where the type has several sets of defaults
/// the key `preset`, which chose among these. Without a type: the keys beside it, for their description.
template <class Options>
struct TypedOptions {
  std::string type;
  Options options;
  std::string preset = {};
  std::vector<std::string> presets = {};
  void Bind(OptionsBinder& b) {
    if (!type.empty()) b.Choice("type", type, std::vector<std::string>{type});
    BindPreset(b, presets, &preset);
    BindAny(b, options);
  }
  static void BindPreset(OptionsBinder& b, const std::vector<std::string>& presets, std::string* preset) {
    if (!presets.empty()) b.Choice("preset", *preset, presets).Help("the options that the keys below change");
  }
};

}  // namespace diffsac
