#pragma once

#include <string>

#include "lab/options/config.h"

namespace diffsac {

/// What ConfigFromJson (lab/options/config_json.h) reads, on one line, keys in their order. Numbers keep their digits.
std::string ToJson(const Config& config);

}  // namespace diffsac
