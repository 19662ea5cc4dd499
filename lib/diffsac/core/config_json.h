#pragma once

#include <string>

#include "diffsac/core/config.h"

namespace diffsac {

/// Configurations as checkpoints hold them. Numbers keep their digits both ways.
///
/// Parses a JSON object; `name` stands for the file in messages. Throws Error for anything else, and for duplicate
/// keys.
Config ConfigFromJson(const std::string& text, const std::string& name);
/// On one line, keys in their order.
std::string ToJson(const Config& config);

}  // namespace diffsac
