#include <cmath>
#include <filesystem>
#include <ostream>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/eval/format.h"
#include "lab/report/compare_runs.h"
#include "lab/report/html_page.h"
#include "lab/report/interval_table.h"
#include "lab/report/markdown_report.h"
#include "lab/report/run_files.h"
#include "lab/report/run_reader.h"

namespace diffsac {
namespace {

std::string NumberText(double value, const char* format) {
  return std::isnan(value) ? kUnknown : Format(format, value);
}

std::string DifferenceText(const RowComparison& row) {
  if (!row.difference) return NumberText(row.b - row.a, "%+.1f");
  return IntervalText(*row.difference, IntervalKind::kDifference);
}

void AddRow(std::vector<std::string> cells, bool bold, std::size_t column, Table* table) {
  Table::Row row{std::move(cells), std::vector<bool>(table->columns.size(), false), false};
  row.best[column] = bold;
  table->rows.push_back(std::move(row));
}

Table RowsTable(const RunComparison& comparison) {
  Table table;
  const bool truth = comparison.metric != "inliers";
  table.heading = "B minus A, " + (truth ? comparison.metric + ", with 95 % paired bootstrap intervals"
                                         : std::string("median inliers (no truth)"));
  table.columns = {"row", "condition", "A", "B", "B − A", "problems", "ms A", "ms B"};
  const char* format = truth ? "%.3f" : "%.1f";
  for (const RowComparison& row : comparison.rows) {
    const bool certain = row.difference && IsCertain(*row.difference, IntervalKind::kDifference);
    AddRow({row.row, row.condition, NumberText(row.a, format), NumberText(row.b, format), DifferenceText(row),
            std::to_string(row.problems), NumberText(row.ms_a, "%.3g"), NumberText(row.ms_b, "%.3g")},
           certain, 4, &table);
  }
  return table;
}

std::string AnswerText(const ProblemRecord& record, const Tolerance& tolerance) {
  if (record.status != Status::kOk) return std::string(ToString(record.status));
  const double error = ShownError(record.error, tolerance);
  return std::isnan(error) ? kUnknown : FixedNumber(error, 2);
}

Table ChangedTable(const RunComparison& comparison) {
  Table table;
  table.heading =
      std::string("problems that changed most, errors in ") + (comparison.metric == "recall" ? "% of the points"
                                                               : comparison.tolerance.pixels ? "pixels"
                                                                                             : "degrees");
  table.columns = {"problem", "scene", "condition", "row", "error A", "error B", "inliers A", "inliers B"};
  for (const ChangedProblem& problem : comparison.changed)
    AddRow({problem.id, problem.scene, problem.condition, problem.row, AnswerText(problem.a, comparison.tolerance),
            AnswerText(problem.b, comparison.tolerance), std::to_string(problem.a.inliers),
            std::to_string(problem.b.inliers)},
           false, 0, &table);
  return table;
}

std::string Title(const RunComparison& comparison) { return comparison.name_b + " against " + comparison.name_a; }

/// What is not in the tables, a line each.
std::vector<std::string> Remarks(const RunComparison& comparison) {
  std::vector<std::string> lines = comparison.only_one;
  for (const RowComparison& row : comparison.rows)
    if (row.only_a > 0 || row.only_b > 0)
      lines.push_back(row.row + ", " + row.condition + ": " + std::to_string(row.only_a) + " problems of A alone and " +
                      std::to_string(row.only_b) + " of B alone are left out");
  return lines;
}

std::string Markdown(const RunComparison& comparison) {
  std::string text = "# " + Title(comparison) + "\n\nA: " + comparison.name_a + ", B: " + comparison.name_b +
                     ". In bold where the interval leaves zero out.\n";
  for (const Table& table : ComparisonTables(comparison))
    if (!table.rows.empty()) text += "\n## " + table.heading + "\n\n" + MarkdownTable(table);
  if (comparison.changed.empty()) text += "\nAll problems have the same answers.\n";
  for (const std::string& line : Remarks(comparison)) text += "\n" + line + ".\n";
  if (!comparison.configuration.empty()) text += "\n## configuration, A → B\n\n";
  for (const std::string& line : comparison.configuration) text += "    " + line + "\n";
  return text;
}

std::string TablesCsv(const std::vector<Table>& tables) {
  const auto line = [](const std::vector<std::string>& cells) {
    std::string text;
    for (std::size_t i = 0; i < cells.size(); ++i)
      text += (i == 0 ? "" : ",") + (cells[i] == kUnknown ? std::string() : CsvText(cells[i]));
    return text + "\n";
  };
  std::string text;
  for (const Table& table : tables) {
    text += (text.empty() ? "" : "\n") + line({table.heading}) + line(table.columns);
    for (const Table::Row& row : table.rows) text += line(row.cells);
  }
  return text;
}

std::string HtmlOf(const RunComparison& comparison) {
  HtmlPage page(Title(comparison));
  page.AddSubtitle("A: " + comparison.name_a + ", B: " + comparison.name_b);
  page.AddSection("Rows");
  page.AddTable(RowsTable(comparison), "In bold where the interval leaves zero out.");
  for (const std::string& line : Remarks(comparison)) page.AddText(line + ".");
  page.AddSection("Problems");
  if (comparison.changed.empty())
    page.AddText("All problems have the same answers.");
  else
    page.AddTable(ChangedTable(comparison));
  if (comparison.configuration.empty()) return page.Text();
  page.AddSection("Configuration, A → B");
  for (const std::string& line : comparison.configuration) page.AddText(line);
  return page.Text();
}

std::string NameOf(const std::string& folder) {
  const auto path = std::filesystem::path(folder).lexically_normal();
  return (path.has_filename() ? path.filename() : path.parent_path().filename()).string();
}

}  // namespace

std::vector<Table> ComparisonTables(const RunComparison& comparison) {
  return {RowsTable(comparison), ChangedTable(comparison)};
}

void CompareFolders(const std::vector<std::string>& folders, const std::string& output, std::ostream& out) {
  if (folders.size() != 2) throw Error("--compare: expected two run folders, found " + std::to_string(folders.size()));
  const ExperimentResults a = ReadRun(folders[0]), b = ReadRun(folders[1]);
  std::string name_a = NameOf(folders[0]), name_b = NameOf(folders[1]);
  const std::string folder = output.empty() ? "runs/compare-" + name_a + "-" + name_b : output;
  if (name_a == name_b) {
    name_a = folders[0];
    name_b = folders[1];
  }
  const RunComparison comparison = CompareRuns(a, b, name_a, name_b);
  MakeWritableFolder(folder);
  const std::string text = Markdown(comparison);
  WriteFileAtomically(folder + "/compare.md", text);
  WriteFileAtomically(folder + "/compare.csv", TablesCsv(ComparisonTables(comparison)));
  WriteFileAtomically(folder + "/report.html", HtmlOf(comparison));
  out << text << "\nwritten to " << folder << std::endl;
}

}  // namespace diffsac
