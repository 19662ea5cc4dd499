#include "lab/eval/run_files.h"

#include <algorithm>
#include <cmath>

#include "lab/eval/tables.h"

namespace diffsac {
namespace {

// Columns on a terminal: characters, not bytes.
std::size_t Width(const std::string& text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
}

std::string Escaped(const std::string& text, const std::string& special) {
  std::string out;
  for (const char c : text) {
    if (special.find(c) != std::string::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string MarkdownRow(const std::vector<std::string>& cells, const std::vector<std::size_t>& widths) {
  std::string line = "|";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string padding(widths[i] - Width(cells[i]), ' ');
    line += i == 0 ? " " + cells[i] + padding + " |" : " " + padding + cells[i] + " |";
  }
  return line + "\n";
}

bool AllShareProblems(const ExperimentResults& results) {
  for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c)
    if (!RowsShareProblems(results, c)) return false;
  return true;
}

// Where there is no truth to tell.
std::string ChanceNote(const ExperimentResults& results) {
  std::string rows;
  for (const Cell& cell : results.cells) {
    const auto chance = std::count_if(cell.records.begin(), cell.records.end(), [&](const ProblemRecord& record) {
      return record.MayBeChance() && std::isnan(MainError(record.error, results.experiment.tolerance()));
    });
    if (chance == 0) continue;
    rows += (rows.empty() ? "" : ", ") + results.experiment.methods[cell.method].label + " " + std::to_string(chance) +
            " of " + std::to_string(cell.records.size());
  }
  return rows.empty() ? "" : "No more inliers than points of no structure would give: " + rows + ".\n";
}

}  // namespace

std::string ReportSetting(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  std::size_t most = 0;
  for (const Cell& cell : results.cells) most = std::max(most, cell.records.size());
  std::string seeds = "seed " + std::to_string(experiment.seed);
  if (!results.seeds.empty()) {
    seeds = "mean of seeds";
    for (const std::uint64_t seed : results.seeds)
      seeds += (seed == results.seeds.front() ? " " : ", ") + std::to_string(seed);
  }
  const bool one = experiment.conditions.size() == 1;
  return std::to_string(most) + " problems" + (one ? "" : " a condition (" + experiment.condition_label + ")") + ", " +
         seeds;
}

std::string MarkdownTable(const Table& table) {
  std::vector<std::vector<std::string>> lines = {table.columns};
  for (const Table::Row& row : table.rows) {
    lines.push_back(row.cells);
    for (std::size_t i = 0; i < row.cells.size(); ++i)
      if (row.best[i]) lines.back()[i] = "**" + row.cells[i] + "**";
  }
  std::vector<std::size_t> widths(table.columns.size(), 3);
  for (auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      line[i] = Escaped(line[i], "|");
      widths[i] = std::max(widths[i], Width(line[i]));
    }
  }
  std::string text = MarkdownRow(lines.front(), widths) + "|";
  for (std::size_t i = 0; i < widths.size(); ++i)
    text += i == 0 ? std::string(widths[i] + 2, '-') + "|" : std::string(widths[i] + 1, '-') + ":|";
  text += "\n";
  for (std::size_t i = 1; i < lines.size(); ++i) text += MarkdownRow(lines[i], widths);
  return text;
}

std::string ReportNotes(const Report& report) {
  const ExperimentResults& results = report.results;
  const ExperimentOptions& experiment = results.experiment;
  std::string text =
      "hypotheses: models solved or scored, those of features and local optimisation included; ms: milliseconds a "
      "problem; both medians over all problems.";
  if (JudgesInstances(results))
    text += kInstanceNote;
  else if (MostScenes(results) > 1)
    text += " Medians of errors and AUC are unweighted means over the scenes, failures are sums.";
  text += "\n";
  if (!AllShareProblems(results))
    text +=
        "Rows are of different problems (other seeds or options of generated data), so none is marked as the best.\n";
  text += ChanceNote(results);
  const bool other_data = std::any_of(experiment.paper.begin(), experiment.paper.end(),
                                      [](const auto& row) { return !row.second.same_data; });
  if (other_data) text += "Rows marked \"paper, other data\" are the paper's figures; its data is not public.\n";
  return text;
}

std::string MarkdownReport(const Report& report) {
  const ExperimentResults& results = report.results;
  const ExperimentOptions& experiment = results.experiment;
  std::string text = "# " + (experiment.title.empty() ? experiment.name : experiment.title) + "\n\n";
  if (results.partial) text += "**Partial results: the run was interrupted.**\n\n";
  text += ReportSetting(results) +
          ". Best in bold; references that are told more than the points (oracle) do not compete.\n";
  for (const Table& table : report.tables) text += "\n## " + table.heading + "\n\n" + MarkdownTable(table);
  text += "\n" + ReportNotes(report);
  for (const std::string& row : experiment.left_out) text += "\nLeft out: " + row + ".\n";
  if (!experiment.notes.empty()) text += "\n" + experiment.notes + "\n";
  return text;
}

}  // namespace diffsac
