#pragma once

#include <string>

#include "diffsac/core/config.h"

namespace diffsac {

/// What ConfigFromJson (core/config_json.h) reads, on one line, keys in their order. Numbers keep their digits.
std::string ToJson(const Config& config);

}  // namespace diffsac
