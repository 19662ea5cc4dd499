#include "lab/eval/sweep.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "diffsac/core/config_tree.h"
#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/eval/digest.h"

namespace diffsac {
namespace {

constexpr const char* kSweep = "sweep";

[[noreturn]] void FailAt(const ConfigTree& tree, const std::string& what) {
  const std::string place = PlaceText(tree.place);
  throw Error((place.empty() ? "" : place + ": ") + kSweep + ": " + what);
}

bool IsAxis(const std::string& key) { return key.find('.') != std::string::npos || key == "seed" || key == "problems"; }

/// A misspelt name would make a row or setting that nothing uses.
void CheckNamed(const ConfigTree& experiment, const ConfigEntry& entry) {
  const std::vector<std::string> path = SplitPath(entry.key);
  if (path[0] != "methods" && path[0] != "settings") return;
  const ConfigTree* parts = experiment.Find(path[0]);
  if (parts != nullptr && parts->kind == ConfigTree::Kind::kSequence)
    FailAt(entry.value, entry.key + ": methods must be a map by name for this, not a list");
  if (parts == nullptr || parts->Find(path[1]) == nullptr)
    FailAt(entry.value, entry.key + ": the experiment has no '" + path[0] + "." + path[1] + "'");
}

std::vector<std::string> ValuesOf(const ConfigEntry& entry) {
  const ConfigTree& values = entry.value;
  if (values.kind != ConfigTree::Kind::kSequence || values.items.empty())
    FailAt(values, entry.key + ": expected a list of values");
  std::vector<std::string> texts;
  for (const ConfigTree& value : values.items) {
    if (value.kind != ConfigTree::Kind::kScalar) FailAt(value, entry.key + ": expected plain values");
    texts.push_back(FlowYaml(value));
  }
  if (std::set(texts.begin(), texts.end()).size() < texts.size()) FailAt(values, entry.key + ": a value stands twice");
  return texts;
}

std::string LastParts(const std::string& key, std::size_t count) {
  std::vector<std::string> path = SplitPath(key);
  path.erase(path.begin(), path.end() - static_cast<std::ptrdiff_t>(std::min(count, path.size())));
  return JoinPath(path);
}

void Shorten(std::vector<SweepAxis>* axes) {
  for (std::size_t i = 0; i < axes->size(); ++i) {
    const auto shared = [&](std::size_t parts) {
      for (std::size_t k = 0; k < axes->size(); ++k)
        if (k != i && LastParts((*axes)[k].key, parts) == LastParts((*axes)[i].key, parts)) return true;
      return false;
    };
    std::size_t parts = 1;
    while (shared(parts)) ++parts;  // Keys differ, so this ends.
    (*axes)[i].shown = LastParts((*axes)[i].key, parts);
  }
}

/// A row at one point.
struct RowAtPoint {
  std::size_t point = 0, method = 0;
  std::string signature;  ///< All that its results depend on, but for the seed.
};

/// Rows that have the values of axes in their names are no combinations of the factors, nor those that strata name.
void ForgetLostRows(ExperimentOptions* experiment) {
  const auto lost = [&](const std::string& name) { return experiment->RowOf(name) == experiment->methods.size(); };
  for (StrataOptions& strata : experiment->strata) std::erase_if(strata.rows, lost);
  const std::vector<std::vector<std::string>> combinations = CombinationsOf(experiment->factors);
  if (std::all_of(combinations.begin(), combinations.end(),
                  [&](const auto& levels) { return lost(FactorRowName(levels)); }))
    experiment->factors.clear();
}

std::string SignatureOf(const ExperimentOptions& experiment, std::size_t method) {
  std::string text = std::to_string(experiment.problems) + "\n";
  for (const Condition& condition : experiment.conditions) text += ToYaml(condition.data) + "\n";
  return text + ToYaml(experiment.methods[method].config);
}

/// By the rows' names, in the order in which they first stand. seeds_alone: all points differ in the seed alone, so
/// that a row is the same at all of them, though its network may have been trained with the seed.
std::vector<std::vector<RowAtPoint>> RowsByName(const std::vector<ExperimentResults>& results, bool seeds_alone) {
  std::vector<std::string> names;
  std::vector<std::vector<RowAtPoint>> rows;
  for (std::size_t p = 0; p < results.size(); ++p) {
    const ExperimentOptions& experiment = results[p].experiment;
    for (std::size_t m = 0; m < experiment.methods.size(); ++m) {
      const auto place =
          static_cast<std::size_t>(std::find(names.begin(), names.end(), experiment.methods[m].name) - names.begin());
      if (place == names.size()) {
        names.push_back(experiment.methods[m].name);
        rows.emplace_back();
      }
      rows[place].push_back({p, m, seeds_alone ? "" : SignatureOf(experiment, m)});
    }
  }
  return rows;
}

/// Whether a row differs between two points that differ in this axis alone.
bool Matters(std::size_t axis, const std::vector<RowAtPoint>& row, const std::vector<SweepPoint>& points) {
  const auto others = [&](std::size_t p) {
    std::vector<std::string> parts = points[p].parts;
    parts[axis].clear();
    return parts;
  };
  for (const RowAtPoint& a : row)
    for (const RowAtPoint& b : row)
      if (a.signature != b.signature && others(a.point) == others(b.point)) return true;
  return false;
}

void CheckAlike(const SweepPoint& first, const ExperimentOptions& a, const SweepPoint& point,
                const ExperimentOptions& b) {
  const bool same =
      a.task == b.task && std::equal(a.conditions.begin(), a.conditions.end(), b.conditions.begin(), b.conditions.end(),
                                     [](const Condition& x, const Condition& y) { return x.name == y.name; });
  if (!same)
    throw Error(std::string(kSweep) + ": '" + first.name + "' and '" + point.name +
                "' have different tasks or conditions");
}

/// The seeds of points that differ in nothing else; empty where they differ in more.
std::vector<std::uint64_t> SeedsAlone(const std::vector<SweepPoint>& points,
                                      const std::vector<ExperimentResults>& results) {
  std::vector<std::uint64_t> seeds;
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (points[p].assignments.size() != 1 || !points[p].assignments.front().starts_with("seed=")) return {};
    seeds.push_back(results[p].experiment.seed);
  }
  return seeds;
}

/// The first point's results without rows, and, unless rows keep their names, without what names rows.
ExperimentResults EmptyOf(const ExperimentResults& first, const std::vector<std::uint64_t>& seeds) {
  ExperimentResults joined;
  joined.experiment = first.experiment;
  joined.dataset = first.dataset;
  joined.git_revision = first.git_revision;
  joined.machine = first.machine;
  joined.problems = first.problems;
  ExperimentOptions& experiment = joined.experiment;
  experiment.methods.clear();
  experiment.estimates = false;
  joined.seeds = seeds;
  if (!seeds.empty()) {
    joined.learned = first.learned;
    return joined;
  }
  experiment.compare.clear();
  experiment.paper.clear();
  experiment.reference.clear();
  experiment.figures = {};
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

/// The points at which a row is the same but for the seed, as one row of all their records.
void AddRow(const std::vector<const RowAtPoint*>& alike, const SweepPoint& point, const std::vector<std::size_t>& axes,
            const std::vector<ExperimentResults>& results, ProblemNumbers* numbers, ExperimentResults* joined) {
  const RowAtPoint& first = *alike.front();
  EstimatorRow row = results[first.point].experiment.methods[first.method];
  for (const std::size_t axis : axes) {
    row.name += " " + point.parts[axis];
    row.label += ", " + point.parts[axis];
  }
  if (joined->seeds.empty()) {
    if (alike.size() > 1) row.label += ", mean of " + std::to_string(alike.size()) + " seeds";
    row.series.clear();
  }
  const std::size_t place = joined->experiment.methods.size();
  std::map<std::size_t, Cell> cells;
  for (const RowAtPoint* at : alike)
    for (const Cell& cell : results[at->point].cells) {
      if (cell.method != at->method) continue;
      Cell& all = cells.try_emplace(cell.condition, Cell{cell.condition, place, {}, {}}).first->second;
      all.records.insert(all.records.end(), cell.records.begin(), cell.records.end());
      for (auto record = all.records.end() - cell.records.size(); record != all.records.end(); ++record)
        record->run = static_cast<int>(at->point);
    }
  for (auto& [condition, cell] : cells) {
    numbers->Renumber(&cell);
    joined->cells.push_back(std::move(cell));
  }
  joined->experiment.methods.push_back(std::move(row));
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

std::vector<SweepAxis> SweepAxes(const Config& experiment) {
  const ConfigTree* root = experiment.impl_->Get();
  const ConfigTree* sweep = root == nullptr ? nullptr : root->Find(kSweep);
  std::vector<SweepAxis> axes;
  if (sweep == nullptr) return axes;
  for (const ConfigEntry& entry : sweep->entries) {
    if (!IsAxis(entry.key)) continue;
    CheckNamed(*root, entry);
    axes.push_back({entry.key, entry.key, ValuesOf(entry)});
  }
  Shorten(&axes);
  return axes;
}

Config WithoutSweepAxes(const Config& experiment) {
  Config rest = experiment.Without({kSweep});
  const ConfigTree* root = experiment.impl_->Get();
  const ConfigTree* sweep = root == nullptr ? nullptr : root->Find(kSweep);
  if (sweep == nullptr) return rest;
  ConfigTree conditions = *sweep;
  std::erase_if(conditions.entries, [](const ConfigEntry& entry) { return IsAxis(entry.key); });
  if (conditions.entries.empty() && !sweep->entries.empty()) return rest;
  ConfigTree& written = rest.impl_->document->root;
  written.entries.push_back({kSweep, std::move(conditions)});
  return rest;
}

std::vector<SweepPoint> SweepPoints(const std::vector<SweepAxis>& axes) {
  std::vector<SweepPoint> points(1);
  for (const SweepAxis& axis : axes) {
    std::vector<SweepPoint> next;
    for (const SweepPoint& point : points)
      for (const std::string& value : axis.values) {
        next.push_back(point);
        next.back().parts.push_back(axis.shown + "=" + value);
        next.back().name += (point.name.empty() ? "" : " ") + next.back().parts.back();
        next.back().assignments.push_back(axis.key + "=" + value);
      }
    points = std::move(next);
  }
  return points;
}

ExperimentResults JoinSweep(const std::vector<SweepPoint>& points, const std::vector<ExperimentResults>& results) {
  ExperimentResults joined = EmptyOf(results.front(), SeedsAlone(points, results));
  ProblemNumbers numbers;
  for (std::size_t p = 0; p < results.size(); ++p) {
    CheckAlike(points.front(), results.front().experiment, points[p], results[p].experiment);
    joined.partial = joined.partial || results[p].partial;
  }
  for (const std::vector<RowAtPoint>& row : RowsByName(results, !joined.seeds.empty())) {
    std::vector<std::size_t> axes;
    for (std::size_t axis = 0; axis < points.front().parts.size(); ++axis)
      if (Matters(axis, row, points)) axes.push_back(axis);
    // At points that differ in what makes no difference the row is the same, seeds apart.
    std::set<std::pair<std::string, std::uint64_t>> seen;
    std::vector<std::vector<const RowAtPoint*>> different;
    for (const RowAtPoint& at : row) {
      if (!seen.insert({at.signature, results[at.point].experiment.seed}).second) continue;
      const auto same = std::find_if(different.begin(), different.end(),
                                     [&](const auto& alike) { return alike.front()->signature == at.signature; });
      if (same == different.end())
        different.push_back({&at});
      else
        same->push_back(&at);
    }
    for (const auto& alike : different) AddRow(alike, points[alike.front()->point], axes, results, &numbers, &joined);
  }
  joined.facts = JoinedFacts(results);
  ForgetLostRows(&joined.experiment);
  std::stable_sort(joined.cells.begin(), joined.cells.end(),
                   [](const Cell& a, const Cell& b) { return a.condition < b.condition; });
  return joined;
}

}  // namespace diffsac
