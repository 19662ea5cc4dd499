#pragma once

#include <string>

#include "lab/eval/results.h"

namespace diffsac {

/// The file of a shard's run folder that holds all that tables need.
inline constexpr const char* kShardRecords = "records.jsonl";

/// A shard's results as text that reads back to the same bits: a line of JSON that says what was run, then a line, a
/// JSON array, for each problem and method. Numbers have all their digits; those that are not finite are "nan", "inf",
/// "-inf". `setup` is what was run beside the experiment (checkpoint, device): shards with another one don't join.
std::string ShardRecords(const ExperimentResults& results, const std::string& setup);

/// What the text of a shard says.
struct ShardContent {
  std::string name;        ///< For messages: the folder.
  std::string experiment;  ///< YAML; number of threads left out, as it changes no result.
  std::string setup;
  ExperimentResults results;  ///< Without kept fits and traces.
};

/// Throws Error, naming `name`, for a text that is none or was cut off.
ShardContent ReadShardRecords(const std::string& text, const std::string& name);

}  // namespace diffsac
