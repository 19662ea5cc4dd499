#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "lab/eval/shard_records.h"

namespace diffsac {

/// Joins all shards of one run, in any order: the numbers are those of a run without shards, times excepted. Throws
/// Error, naming the shard, for one that is missing, stands twice, was interrupted or has another configuration or
/// data, and where records are missing. `partial_allowed`: where some were interrupted the results are partial.
ExperimentResults MergeShards(std::vector<ShardContent> shards, bool partial_allowed = false);

/// Copies the kept fits of one run's folder (example_files.h) to another, or removes those of an earlier run.
void CopyFits(const std::string& from, const std::string& to);

/// `diffsac_eval --merge`: reads the shards' folders, writes the whole run's folder (empty: runs/<name>), with
/// pictures, and prints the tables. Pictures of examples are copied from the first shard's folder. Throws Error.
void MergeFolders(const std::vector<std::string>& folders, const std::string& output, std::ostream& out);

}  // namespace diffsac
