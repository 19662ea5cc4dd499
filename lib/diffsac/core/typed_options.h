#pragma once

#include <string>
#include <vector>

#include "diffsac/core/options.h"

namespace diffsac {

/// The options that the key `type` chose, with that key beside them.
template <class Options>
struct TypedOptions {
  std::string type;
  Options options;
  void Bind(OptionsBinder& b) {
    b.Choice("type", type, std::vector<std::string>{type});
    options.Bind(b);
  }
};

}  // namespace diffsac
