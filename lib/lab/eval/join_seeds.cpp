#include "lab/eval/join_seeds.h"

#include <algorithm>
#include <map>
#include <utility>

#include "diffsac/core/status.h"
#include "lab/eval/digest.h"

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
      Cell& all = cells.try_emplace(cell.condition, Cell{cell.condition, place, {}, {}}).first->second;
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

}  // namespace diffsac
