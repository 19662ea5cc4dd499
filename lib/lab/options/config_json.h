#pragma once

#include <string>

#include "lab/options/config.h"

namespace diffsac {

struct CheckpointInfo;
struct TrainedConfig;

/// A configuration as checkpoints hold it, a JSON object whose numbers keep their digits.
std::string ToJson(const Config& config);

/// Parses a JSON object; `name` stands for the file in messages. Throws Error for anything else, and for duplicate
/// keys.
Config ConfigFromJson(const std::string& text, const std::string& name);

/// The training configuration of a checkpoint. Throws Error, naming the file, when it cannot be read.
Config CheckpointConfig(const CheckpointInfo& info, const std::string& path);
Config ConfigOf(const TrainedConfig& trained);

}  // namespace diffsac
