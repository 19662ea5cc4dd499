#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "lab/eval/results.h"

namespace diffsac {

/// "2/3", the second of three. Throws Error for anything else and where 1 ≤ i ≤ n does not hold.
Shard ShardFromText(const std::string& text);

/// "2/3".
std::string ToString(const Shard& shard);

/// The numbers below `count` that a shard takes, ascending. `batch` following ones always stay together, every
/// shard.count-th group of them is this shard's: a network sees the same batches in any sharding, so that its outputs
/// are the same to the last bit. Where there are fewer batches than shards some shards get none.
std::vector<std::size_t> ShardPositions(std::size_t count, std::size_t batch, const Shard& shard);

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

/// Joins all shards of one run, in any order: the numbers are those of a run without shards, times excepted. Throws
/// Error, naming the shard, for one that is missing, stands twice, was interrupted or has another configuration or
/// data, and where records are missing. `partial_allowed`: where some were interrupted the results are partial.
ExperimentResults MergeShards(std::vector<ShardContent> shards, bool partial_allowed = false);

/// Writes all that a whole run leaves in its folder, has it told by scripts/report and prints the tables. `fits_of`:
/// the folder of the run whose kept fits are this one's; empty: those of `results`. Throws Error.
void WriteWholeRun(const ExperimentResults& results, const std::string& fits_of, const std::string& folder,
                   std::ostream& out);

/// `diffsac_eval --merge`: reads the shards' folders, writes the whole run's folder (empty: runs/<name>), with
/// pictures, and prints the tables. Pictures of examples are copied from the first shard's folder. Throws Error.
void MergeFolders(const std::vector<std::string>& folders, const std::string& output, std::ostream& out);

}  // namespace diffsac
