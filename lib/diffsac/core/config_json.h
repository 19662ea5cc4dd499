#pragma once

#include <string>

#include "diffsac/core/config.h"

namespace diffsac {

/// A configuration as checkpoints hold it (lab/config/config_to_json.h writes it). Numbers keep their digits.
///
/// Parses a JSON object; `name` stands for the file in messages. Throws Error for anything else, and for duplicate
/// keys.
Config ConfigFromJson(const std::string& text, const std::string& name);

}  // namespace diffsac
