#include "lab/report/effects_page.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <ostream>
#include <utility>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/eval/format.h"
#include "lab/report/effect_tables.h"
#include "lab/report/markdown_report.h"
#include "lab/report/metric_table.h"
#include "lab/report/results_page.h"
#include "lab/report/run_reader.h"
#include "lab/report/strata_tables.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBestRows = 8;

/// The level of a run that is called so.
std::optional<FactorLevel> FindLevel(const ExperimentOptions& experiment, const std::string& name) {
  for (const FactorLevel& at : LevelsOf(experiment))
    if (LevelName(experiment, at) == name) return at;
  return std::nullopt;
}

/// The names of all runs' levels, those of one factor together, in the order in which they first appear.
std::vector<std::pair<std::string, std::string>> AllLevels(const std::vector<EffectRun>& runs) {
  std::vector<std::pair<std::string, std::string>> levels;  // Factor, name.
  for (const EffectRun& run : runs) {
    const ExperimentOptions& experiment = run.report.results.experiment;
    for (const FactorLevel& at : LevelsOf(experiment)) {
      const std::pair<std::string, std::string> level = {experiment.factors[at.factor].first,
                                                         LevelName(experiment, at)};
      if (std::find(levels.begin(), levels.end(), level) != levels.end()) continue;
      const auto last =
          std::find_if(levels.rbegin(), levels.rend(), [&](const auto& l) { return l.first == level.first; });
      levels.insert(last == levels.rend() ? levels.end() : last.base(), level);
    }
  }
  return levels;
}

Table OverviewOf(const std::vector<EffectRun>& runs, const std::string& what, EffectPart part, IntervalKind kind) {
  std::vector<std::string> names;
  for (const EffectRun& run : runs) names.push_back(run.report.results.experiment.name);
  names = ShortNames(names);
  Table table;
  table.heading = "effects on " + what + ", all tables";
  table.columns = {"factor: level"};
  for (std::size_t r = 0; r < runs.size(); ++r)
    for (std::size_t c = 0; c < runs[r].report.effects.size(); ++c) {
      const auto& conditions = runs[r].report.results.experiment.conditions;
      table.columns.push_back(names[r] + (conditions.size() > 1 ? ": " + conditions[c].label : ""));
    }
  for (const auto& [factor, name] : AllLevels(runs)) {
    std::vector<std::optional<ConfidenceInterval>> values;
    bool is_first = true;
    for (const EffectRun& run : runs) {
      const auto at = FindLevel(run.report.results.experiment, name);
      is_first = is_first && (!at || at->level == 0);
      for (const FactorEffects& effects : run.report.effects)
        values.push_back(!at || at->level == 0 ? std::nullopt : effects[at->factor][at->level].*part);
    }
    AddIntervalRow(name + (is_first ? " (first)" : ""), values, kind, &table);
  }
  return table;
}

/// The pictures of a run that the page shows.
std::string PicturesText(const EffectRun& run, const std::string& page, const std::string& name) {
  const ExperimentOptions& experiment = run.report.results.experiment;
  std::vector<std::string> pictures = {"effects"};
  for (const StrataOptions& strata : experiment.strata) pictures.push_back("strata_" + ToString(strata.by));
  std::string text;
  for (const std::string& picture : pictures) {
    const std::string path = (fs::path(run.folder) / (picture + ".png")).string();
    if (!page.empty() && fs::exists(path)) text += PictureBeside(path, page, name);
  }
  return text;
}

std::string SectionOf(const EffectRun& run, const std::string& page) {
  const Report& report = run.report;
  const ExperimentOptions& experiment = report.results.experiment;
  std::string text = "## " + (experiment.title.empty() ? experiment.name : experiment.title) + "\n\n";
  if (report.results.partial) text += "**Partial results: the run was interrupted.**\n\n";
  text += ReportSetting(report.results) + ".\n\n";
  for (const std::string& what : experiment.left_out) text += "Left out: " + what + ".\n\n";
  text += PicturesText(run, page, fs::path(page).stem().string() + "_" + experiment.name);
  std::vector<Table> tables = EffectTables(report);
  for (std::size_t c = 0; c < experiment.conditions.size(); ++c) tables.push_back(BestRows(report, c));
  for (Table& table : StrataTables(report)) tables.push_back(std::move(table));
  for (const Table& table : tables) text += "### " + table.heading + "\n\n" + MarkdownTable(table) + "\n";
  for (const std::string& note : {MissingCombinations(report), StrataNote(report)})
    if (!note.empty()) text += note + "\n";
  return text + "Of the run " + experiment.name + ":\n\n" + FactsOfRun(run.folder) + "\n";
}

bool HasRun(const std::string& folder) { return fs::exists(fs::path(folder) / "results.json"); }

std::string NameOfFolder(const std::string& folder) {
  const fs::path path = fs::path(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

}  // namespace

std::vector<std::string> ShortNames(const std::vector<std::string>& names) {
  if (names.size() < 2) return names;
  std::size_t shared = names.front().size();
  for (const std::string& name : names) {
    const auto end = std::mismatch(name.begin(), name.end(), names.front().begin(), names.front().end()).first;
    shared = std::min(shared, static_cast<std::size_t>(end - name.begin()));
  }
  const std::size_t underscore = shared == 0 ? std::string::npos : names.front().rfind('_', shared - 1);
  if (underscore == std::string::npos) return names;
  std::vector<std::string> shorter;
  for (const std::string& name : names) shorter.push_back(name.substr(underscore + 1));
  return shorter;
}

std::vector<Table> EffectOverview(const std::vector<EffectRun>& runs) {
  return {OverviewOf(runs, "the accuracy", &LevelEffect::accuracy, IntervalKind::kDifference),
          OverviewOf(runs, "milliseconds", &LevelEffect::milliseconds, IntervalKind::kRatio)};
}

Table BestRows(const Report& report, std::size_t condition) {
  const ExperimentOptions& experiment = report.results.experiment;
  const std::string metric = AccuracyMetric(report.results);
  std::vector<const Cell*> cells;
  for (const Cell& cell : report.results.cells)
    if (cell.condition == condition && !std::isnan(report.Of(cell).accuracy.mean) &&
        experiment.methods[cell.method].Competes())
      cells.push_back(&cell);
  std::stable_sort(cells.begin(), cells.end(), [&](const Cell* a, const Cell* b) {
    return report.Of(*a).accuracy.mean > report.Of(*b).accuracy.mean;
  });
  cells.resize(std::min(cells.size(), kBestRows));
  Table table;
  table.heading = "best rows" + ConditionText(experiment, condition);
  table.columns = {"method", metric, "hypotheses", "ms"};
  for (const Cell* cell : cells) {
    const auto median = [&](const char* what) { return report.Metric(condition, cell->method, "mean", what); };
    table.rows.push_back(
        {{experiment.methods[cell->method].label, IntervalText(report.Of(*cell).accuracy, IntervalKind::kValue),
          FixedText(median("hypotheses"), 0), Format("%.3g", median("ms_total"))},
         std::vector<bool>(4, false)});
  }
  return table;
}

void WriteEffectsPage(const std::vector<std::string>& folders, const std::string& page, const std::string& command,
                      std::ostream& out) {
  std::deque<ExperimentResults> results;  // Reports refer to them.
  std::vector<EffectRun> runs;
  std::string missing;
  for (const std::string& folder : folders) {
    if (!HasRun(folder)) {
      missing += "Not made: " + NameOfFolder(folder) + ".\n\n";
      continue;
    }
    results.push_back(ReadRun(folder));
    if (results.back().experiment.factors.empty())
      throw Error("--effects: the experiment of '" + folder + "' has no 'factors'");
    runs.push_back({folder, MakeReport(results.back())});
  }
  if (runs.empty()) throw Error("--effects: none of these folders holds a run of diffsac_eval");
  if (!page.empty()) fs::create_directories(fs::absolute(page).parent_path());
  std::string text = "# What decides\n\nWritten by `" + command + "`. " + kEffectNote + "\n" + missing;
  for (const Table& table : EffectOverview(runs)) text += "## " + table.heading + "\n\n" + MarkdownTable(table) + "\n";
  for (const EffectRun& run : runs) text += SectionOf(run, page);
  if (!page.empty()) WriteFileAtomically(page, text);
  out << text << std::flush;
}

}  // namespace diffsac
