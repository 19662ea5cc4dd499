#include "lab/eval/merge.h"

#include <algorithm>
#include <filesystem>
#include <ostream>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/config/run_directory.h"
#include "lab/config/run_lock.h"
#include "lab/eval/example_files.h"
#include "lab/eval/labelled_points.h"
#include "lab/eval/report_script.h"
#include "lab/eval/run_files.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

std::string Called(const ShardContent& shard) { return shard.name + " (shard " + ToString(shard.results.shard) + ")"; }

// What two texts of several lines differ in: the first line, for one clear line of a message.
std::string FirstDifference(const std::string& a, const std::string& b) {
  const auto [in_a, in_b] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  const auto line = [](const std::string& text, std::string::const_iterator at) {
    const auto offset = static_cast<std::size_t>(at - text.begin());
    const std::size_t before = offset == 0 ? std::string::npos : text.rfind('\n', offset - 1);
    const std::size_t first = before == std::string::npos ? 0 : before + 1;
    const std::size_t start = text.find_first_not_of(" -", first);
    if (start == std::string::npos) return std::string();
    return text.substr(start, text.find('\n', start) - start);
  };
  return "'" + line(a, in_a) + "' and '" + line(b, in_b) + "'";
}

void CheckAlike(const ShardContent& first, const ShardContent& other) {
  const std::string both = Called(first) + " and " + Called(other);
  if (other.results.shard.count != first.results.shard.count)
    throw Error("--merge: " + both + " are parts of different splits");
  if (other.experiment != first.experiment)
    throw Error("--merge: " + both +
                " have different configurations: " + FirstDifference(first.experiment, other.experiment));
  if (other.setup != first.setup)
    throw Error("--merge: " + both + " were run differently: " + FirstDifference(first.setup, other.setup));
  if (other.results.problems != first.results.problems || other.results.dataset != first.results.dataset)
    throw Error("--merge: " + both + " saw different data");
  if (other.results.git_revision != first.results.git_revision)
    LogWarning("--merge: " + both + " were run by different programs, git " + first.results.git_revision + " and " +
               other.results.git_revision);
}

// In the order of the shards; each exactly once.
void CheckComplete(const std::vector<ShardContent>& shards) {
  for (const ShardContent& shard : shards) CheckAlike(shards.front(), shard);
  for (std::size_t i = 1; i < shards.size(); ++i)
    if (shards[i].results.shard == shards[i - 1].results.shard)
      throw Error("--merge: " + shards[i - 1].name + " and " + shards[i].name + " are both shard " +
                  ToString(shards[i].results.shard));
  const int count = shards.front().results.shard.count;
  for (int i = 1; i <= count; ++i)
    if (static_cast<std::size_t>(i) > shards.size() || shards[i - 1].results.shard.index != i)
      throw Error("--merge: shard " + ToString(Shard{i, count}) + " is missing; given are " +
                  std::to_string(shards.size()) + " of " + std::to_string(count));
}

// All records of one method and condition, in the order of the dataset.
Cell JoinCell(std::size_t condition, std::size_t method, std::vector<ShardContent>* shards) {
  Cell joined{condition, method, {}};
  for (ShardContent& shard : *shards)
    for (Cell& cell : shard.results.cells)
      if (cell.condition == condition && cell.method == method)
        std::move(cell.records.begin(), cell.records.end(), std::back_inserter(joined.records));
  std::sort(joined.records.begin(), joined.records.end(),
            [](const auto& a, const auto& b) { return a.index < b.index; });
  return joined;
}

void CheckCell(const ExperimentResults& results, const Cell& cell) {
  const EstimatorRow& row = results.experiment.methods[cell.method];
  const std::string& condition = results.experiment.conditions[cell.condition].name;
  std::size_t expected = row.RunsOn(condition) ? results.problems.at(cell.condition) : 0;
  if (row.max_problems > 0) expected = std::min(expected, static_cast<std::size_t>(row.max_problems));
  bool whole = cell.records.size() == expected;
  for (std::size_t i = 0; whole && i < expected; ++i) whole = cell.records[i].index == i;
  if (!whole)
    throw Error("--merge: method '" + row.name + "', condition '" + condition + "': the shards' records are not the " +
                std::to_string(expected) + " problems, each once");
}

std::string Machines(const std::vector<ShardContent>& shards) {
  std::vector<std::string> machines;
  for (const ShardContent& shard : shards)
    if (std::find(machines.begin(), machines.end(), shard.results.machine) == machines.end())
      machines.push_back(shard.results.machine);
  std::string text;
  for (const std::string& machine : machines) text += (text.empty() ? "" : "; ") + machine;
  return text + " (" + std::to_string(shards.size()) + " shards)";
}

ShardContent ReadShardFolder(const std::string& folder) {
  const std::string path = (fs::path(folder) / kShardRecords).string();
  if (!fs::is_directory(folder)) throw Error("--merge: no folder '" + folder + "'");
  if (!fs::exists(path))
    throw Error("--merge: '" + folder + "' holds no finished shard (" + kShardRecords +
                "), as diffsac_eval --shard i/n "
                "leaves it");
  ShardContent content = ReadShardRecords(ReadFile(path), folder);
  if (content.results.experiment.estimates)
    AddEstimates(ReadEstimates((fs::path(folder) / kEstimatesFile).string()), folder, &content.results);
  return content;
}

// Copies the kept fits of one run's folder to another, or removes those of an earlier run.
void CopyFits(const std::string& from, const std::string& to) {
  const fs::path fits = fs::path(from) / kFitsFile, copy = fs::path(to) / kFitsFile;
  std::error_code code;
  if (!fs::exists(fits, code)) return RemoveFile(copy.string());
  if (!fs::equivalent(from, to, code)) WriteFileAtomically(copy.string(), ReadFile(fits.string()));
}

}  // namespace

ExperimentResults MergeShards(std::vector<ShardContent> shards, bool partial_allowed) {
  if (shards.empty()) throw Error("--merge: expected the folders of all shards");
  std::stable_sort(shards.begin(), shards.end(), [](const ShardContent& a, const ShardContent& b) {
    return a.results.shard.index < b.results.shard.index;
  });
  bool partial = false;
  for (const ShardContent& shard : shards) {
    partial = partial || shard.results.partial;
    if (shard.results.partial && !partial_allowed)
      throw Error("--merge: " + Called(shard) + " was interrupted; run that shard again");
  }
  if (!partial) CheckComplete(shards);
  ExperimentResults results = shards.front().results;
  results.partial = partial;
  results.shard = {};
  results.cells.clear();
  results.reliability.clear();
  for (const ShardContent& shard : shards) AddCurves(shard.results.reliability, &results.reliability);
  results.machine = Machines(shards);
  for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c)
    for (std::size_t m = 0; m < results.experiment.methods.size(); ++m) {
      Cell cell = JoinCell(c, m, &shards);
      if (!partial) CheckCell(results, cell);
      if (!cell.records.empty()) results.cells.push_back(std::move(cell));
    }
  return results;
}

void WriteWholeRun(const ExperimentResults& results, const std::string& fits_of, const std::string& folder,
                   std::ostream& out) {
  const Report report = MakeReport(results);
  WriteResults(report, folder);
  KeepEstimates(results, folder);
  WriteLabels(results, folder);
  if (fits_of.empty())
    WriteFits(results, folder);
  else
    CopyFits(fits_of, folder);
  if (results.seeds.empty()) WritePairs(results, folder);  // Of several seeds they are in the runs' own reports.
  EndResults(report, folder);
  WriteReport(folder);
  out << MarkdownReport(report) << std::endl;
}

void MergeFolders(const std::vector<std::string>& folders, const std::string& output, std::ostream& out) {
  std::vector<ShardContent> shards;
  for (const std::string& folder : folders) shards.push_back(ReadShardFolder(folder));
  std::string first;
  for (const ShardContent& shard : shards)
    if (shard.results.shard.index == 1) first = shard.name;
  const ExperimentResults results = MergeShards(std::move(shards));
  const std::string folder = output.empty() ? "runs/" + results.experiment.name : output;
  const RunLock lock(folder);
  BeginResults(folder);
  const RunDirectory run(folder, "diffsac_eval --merge", WriteExperiment(results.experiment), results.experiment.seed);
  WriteWholeRun(results, first, folder, out);
  out << ResultsText(folder) << std::endl;
}

}  // namespace diffsac
