#include "lab/eval/evaluate.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <ostream>
#include <sstream>
#include <utility>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/config/run_directory.h"
#include "lab/config/run_lock.h"
#include "lab/eval/digest.h"
#include "lab/eval/merge.h"
#include "lab/eval/run_files.h"
#include "lab/eval/selection.h"

namespace diffsac {
namespace {

/// A row of one of the runs.
struct RowOfRun {
  std::size_t run = 0, method = 0;
};

/// By the rows' names, in the order in which they first stand.
std::vector<std::vector<RowOfRun>> RowsByName(const std::vector<ExperimentResults>& results) {
  std::vector<std::string> names;
  std::vector<std::vector<RowOfRun>> rows;
  for (std::size_t r = 0; r < results.size(); ++r) {
    const ExperimentOptions& experiment = results[r].experiment;
    for (std::size_t m = 0; m < experiment.methods.size(); ++m) {
      const auto place =
          static_cast<std::size_t>(std::find(names.begin(), names.end(), experiment.methods[m].name) - names.begin());
      if (place == names.size()) {
        names.push_back(experiment.methods[m].name);
        rows.emplace_back();
      }
      rows[place].push_back({r, m});
    }
  }
  return rows;
}

void CheckAlike(const ExperimentOptions& a, const ExperimentOptions& b) {
  const bool same = std::equal(a.conditions.begin(), a.conditions.end(), b.conditions.begin(), b.conditions.end(),
                               [](const Condition& x, const Condition& y) { return x.name == y.name; });
  if (!same)
    throw Error("seeds: " + std::to_string(a.seed) + " and " + std::to_string(b.seed) + " have different conditions");
}

/// The first run's results without rows.
ExperimentResults EmptyOf(const ExperimentResults& first) {
  ExperimentResults joined;
  joined.experiment = first.experiment;
  joined.dataset = first.dataset;
  joined.git_revision = first.git_revision;
  joined.machine = first.machine;
  joined.problems = first.problems;
  joined.learned = first.learned;
  joined.experiment.methods.clear();
  joined.experiment.estimates = false;
  return joined;
}

/// Numbers problems by scene and id, condition by condition, so that those of several runs can be told apart or paired.
class ProblemNumbers {
 public:
  void Renumber(Cell* cell) {
    auto& known = numbers_[cell->condition];
    for (ProblemRecord& record : cell->records)
      record.index = known.try_emplace({record.scene, record.id}, known.size()).first->second;
  }

 private:
  std::map<std::size_t, std::map<std::pair<std::string, std::string>, std::uint64_t>> numbers_;
};

/// A row of all runs as one row of all their records.
void AddRow(const std::vector<RowOfRun>& row, const std::vector<ExperimentResults>& results, ProblemNumbers* numbers,
            ExperimentResults* joined) {
  const std::size_t place = joined->experiment.methods.size();
  std::map<std::size_t, Cell> cells;
  for (const RowOfRun& at : row)
    for (const Cell& cell : results[at.run].cells) {
      if (cell.method != at.method) continue;
      Cell& all = cells.try_emplace(cell.condition, Cell{cell.condition, place, {}}).first->second;
      all.records.insert(all.records.end(), cell.records.begin(), cell.records.end());
      for (auto record = all.records.end() - cell.records.size(); record != all.records.end(); ++record)
        record->run = static_cast<int>(at.run);
    }
  for (auto& [condition, cell] : cells) {
    numbers->Renumber(&cell);
    joined->cells.push_back(std::move(cell));
  }
  joined->experiment.methods.push_back(results[row.front().run].experiment.methods[row.front().method]);
}

RunFacts JoinedFacts(const std::vector<ExperimentResults>& results) {
  RunFacts joined = results.front().facts;
  joined.seconds = 0.0;
  std::string digests;
  bool alike = true;
  for (const ExperimentResults& one : results) {
    joined.seconds += one.facts.seconds;
    joined.peak_memory_mib = std::max(joined.peak_memory_mib, one.facts.peak_memory_mib);
    alike = alike && one.facts.data_digest == joined.data_digest;
    digests += one.facts.data_digest;
    for (const auto& network : one.facts.networks)
      if (std::find(joined.networks.begin(), joined.networks.end(), network) == joined.networks.end())
        joined.networks.push_back(network);
  }
  if (!alike) joined.data_digest = DigestOfText(digests);
  return joined;
}

EvalRequest RequestOf(int seed, const EvalRequest& request, const std::string& folder) {
  EvalRequest one = request;
  one.seed = seed;
  one.output = (std::filesystem::path(folder) / "points" / ("seed=" + std::to_string(seed))).string();
  one.update = true;
  return one;
}

/// The seeds with which something can run, each read before anything runs, so that a wrong value is found now. `out` is
/// told once what all lack.
std::vector<int> CheckedSeeds(const EvalRequest& request, const std::vector<int>& seeds, std::ostream& out) {
  std::string told;
  // Networks that are trained first may not be there yet.
  const bool any_checkpoint = request.train_missing || !request.context.checkpoint_override.empty();
  std::vector<int> checked;
  for (const int seed : seeds) {
    ExperimentOptions experiment = ReadRequest(RequestOf(seed, request, ""));
    if (request.needs || LeaveOutMissing(any_checkpoint, &experiment)) {
      if (!request.needs && !request.train_missing) WithResolvedRows(experiment, request.context);
      checked.push_back(seed);
      continue;
    }
    const std::string text = NothingIsHere(experiment);
    if (text != told) out << text << std::endl;
    told = text;
  }
  return checked;
}

/// Fits of single problems are the first seed's.
void WriteJoined(const ExperimentResults& results, const std::string& first_run, const std::string& folder,
                 std::ostream& out) {
  ExperimentOptions whole = results.experiment;
  whole.seeds = std::vector<int>(results.seeds.begin(), results.seeds.end());
  RunDirectory(folder, "diffsac_eval", WriteExperiment(whole), whole.seed);
  WriteWholeRun(results, first_run, folder, out);
  out << ResultsText(folder) << std::endl;
}

}  // namespace

ExperimentResults JoinSeeds(const std::vector<ExperimentResults>& results) {
  ExperimentResults joined = EmptyOf(results.front());
  for (const ExperimentResults& one : results) {
    CheckAlike(results.front().experiment, one.experiment);
    joined.seeds.push_back(one.experiment.seed);
    joined.partial = joined.partial || one.partial;
  }
  ProblemNumbers numbers;
  for (const std::vector<RowOfRun>& row : RowsByName(results)) AddRow(row, results, &numbers, &joined);
  joined.facts = JoinedFacts(results);
  std::stable_sort(joined.cells.begin(), joined.cells.end(),
                   [](const Cell& a, const Cell& b) { return a.condition < b.condition; });
  return joined;
}

int EvaluateSeeds(const EvalRequest& request, const ExperimentOptions& experiment, const TraceConfidence& trace,
                  const std::atomic<bool>& stop, std::ostream& out) {
  if (request.group || !request.shard.empty())
    throw Error("several seeds are for one process: start them one by one with --seed, or without --shard");
  const std::vector<int> seeds = CheckedSeeds(request, *experiment.seeds, out);
  if (seeds.empty()) return kExitOk;
  const std::string folder = request.output.empty() ? "runs/" + experiment.name : request.output;
  std::optional<RunLock> lock;
  if (!request.needs) {
    lock.emplace(folder);
    BeginResults(folder);
    const RunDirectory run(folder, "diffsac_eval", WriteExperiment(experiment), experiment.seed);
  }
  std::vector<ExperimentResults> results;
  for (const int seed : seeds) {
    const EvalRequest one = RequestOf(seed, request, folder);
    std::ostringstream table;
    const int code = Evaluate(one, trace, stop, request.needs ? out : table);
    if (request.needs) continue;
    if (code != kExitOk) {
      LogWarning("interrupted at seed=" + std::to_string(seed) + ": the same call goes on from there");
      return code;
    }
    results.push_back(ReadRun(one.output));
    out << "[" << results.size() << "/" << seeds.size() << "] seed=" << seed << ": in " << one.output << std::endl;
  }
  if (!request.needs) WriteJoined(JoinSeeds(results), RequestOf(seeds.front(), request, folder).output, folder, out);
  return kExitOk;
}

}  // namespace diffsac
