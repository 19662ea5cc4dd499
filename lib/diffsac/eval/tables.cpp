#include "diffsac/eval/tables.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace diffsac {
namespace {

constexpr const char* kUnknown = "–";

std::string Fixed(double value, int digits) {
  if (std::isnan(value)) return kUnknown;
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

std::string General(double value) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.3g", value);
  return std::isnan(value) ? kUnknown : text;
}

// What one table shows.
struct Kind {
  std::string heading;
  std::string metric;
  int digits = 3;
  bool higher_is_better = true;
  double PaperValue::*paper = nullptr;
};

double MedianOverAll(const ExperimentResults& results, std::size_t method, double (*get)(const ProblemRecord&)) {
  std::vector<double> values;
  for (const Cell& cell : results.cells) {
    if (cell.method != method) continue;
    for (const ProblemRecord& record : cell.records) values.push_back(get(record));
  }
  return Median(std::move(values));
}

// "2000", or "100–2000" where conditions differ.
std::string CountText(const ExperimentResults& results, std::size_t method) {
  std::size_t low = 0, high = 0;
  for (const Cell& cell : results.cells) {
    if (cell.method != method) continue;
    low = low == 0 ? cell.records.size() : std::min(low, cell.records.size());
    high = std::max(high, cell.records.size());
  }
  return low == high ? std::to_string(high) : std::to_string(low) + kUnknown + std::to_string(high);
}

std::vector<double> RowValues(const ExperimentResults& results, std::size_t method, const std::string& metric) {
  std::vector<double> values(results.experiment.conditions.size(), std::nan(""));
  for (const Cell& cell : results.cells) {
    if (cell.method != method) continue;
    values[cell.condition] = FindMetric(CellMetrics(cell, results.experiment.tolerance()), "mean", metric);
  }
  return values;
}

// A row of numbers for the condition columns, before the best are known.
struct NumberRow {
  std::vector<double> values;
  bool competes = true;
};

// Values that print the same are equally good.
void MarkBest(const std::vector<NumberRow>& numbers, const Kind& kind, Table* table) {
  const std::size_t conditions = numbers.empty() ? 0 : numbers.front().values.size();
  for (std::size_t c = 0; c < conditions; ++c) {
    double best = std::nan("");
    for (const NumberRow& row : numbers) {
      const double value = row.values[c];
      if (!row.competes || std::isnan(value)) continue;
      if (std::isnan(best) || (kind.higher_is_better ? value > best : value < best)) best = value;
    }
    for (std::size_t r = 0; r < numbers.size(); ++r) {
      const std::string text = Fixed(numbers[r].values[c], kind.digits);
      table->rows[r].best[c + 1] =
          numbers[r].competes && !std::isnan(best) && text != kUnknown && text == Fixed(best, kind.digits);
    }
  }
}

bool HasRecords(const ExperimentResults& results, std::size_t method) {
  return std::any_of(results.cells.begin(), results.cells.end(),
                     [&](const Cell& cell) { return cell.method == method; });
}

bool CountsDiffer(const ExperimentResults& results) {
  return std::any_of(results.cells.begin(), results.cells.end(),
                     [&](const Cell& cell) { return cell.records.size() != results.cells.front().records.size(); });
}

void AddMethodRows(const ExperimentResults& results, const Kind& kind, bool with_counts, Table* table) {
  std::vector<NumberRow> numbers;
  for (std::size_t m = 0; m < results.experiment.methods.size(); ++m) {
    if (!HasRecords(results, m)) continue;
    const MethodRow& method = results.experiment.methods[m];
    numbers.push_back({RowValues(results, m, kind.metric), method.Competes()});
    Table::Row row;
    row.cells.push_back(method.label);
    for (const double value : numbers.back().values) row.cells.push_back(Fixed(value, kind.digits));
    const double models = MedianOverAll(results, m, [](const ProblemRecord& r) { return double(r.report.hypotheses); });
    const double ms = MedianOverAll(results, m, [](const ProblemRecord& r) { return r.report.ms_total; });
    row.cells.push_back(method.type == "oracle" ? kUnknown : Fixed(models, 0));
    row.cells.push_back(method.type == "oracle" ? kUnknown : General(ms));
    if (with_counts) row.cells.push_back(CountText(results, m));
    row.best.resize(row.cells.size());
    table->rows.push_back(std::move(row));
  }
  MarkBest(numbers, kind, table);
}

void AddPaperRows(const ExperimentResults& results, const Kind& kind, Table* table) {
  if (kind.paper == nullptr) return;
  for (const PaperRow& paper : results.experiment.paper) {
    Table::Row row;
    bool known = false;
    row.cells.push_back(paper.label + " (paper, other data)");
    for (const Condition& condition : results.experiment.conditions) {
      const auto found = paper.values.find(condition.name);
      const double value = found == paper.values.end() ? std::nan("") : found->second.*kind.paper;
      known = known || !std::isnan(value);
      row.cells.push_back(Fixed(value, 2));
    }
    row.cells.resize(table->columns.size(), "");
    row.best.resize(row.cells.size());
    row.from_paper = true;
    if (known) table->rows.push_back(std::move(row));
  }
}

Table MakeTable(const ExperimentResults& results, const Kind& kind) {
  Table table;
  table.heading = kind.heading;
  table.columns.push_back("method");
  for (const Condition& condition : results.experiment.conditions) table.columns.push_back(condition.label);
  table.columns.insert(table.columns.end(), {"hypotheses", "ms"});
  const bool with_counts = CountsDiffer(results);
  if (with_counts) table.columns.push_back("n");
  AddMethodRows(results, kind, with_counts, &table);
  AddPaperRows(results, kind, &table);
  return table;
}

bool HasTruth(const ExperimentResults& results) {
  for (const Cell& cell : results.cells)
    if (!SceneAccuracies(cell, results.experiment.tolerance()).empty()) return true;
  return false;
}

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

std::string LatexText(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\textbackslash{}";
    else if (c == '~')
      out += "\\textasciitilde{}";
    else if (c == '^')
      out += "\\textasciicircum{}";
    else
      out += Escaped(std::string(1, c), "&%$#_{}");
  }
  for (std::size_t at; (at = out.find(kUnknown)) != std::string::npos;) out.replace(at, 3, "--");
  return out;
}

std::string Setting(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  std::size_t most = 0;
  for (const Cell& cell : results.cells) most = std::max(most, cell.records.size());
  return std::to_string(most) + " problems a condition (" + experiment.condition_label + "), seed " +
         std::to_string(experiment.seed);
}

}  // namespace

std::vector<Table> MakeTables(const ExperimentResults& results) {
  const Tolerance c = results.experiment.tolerance();
  std::vector<Kind> kinds;
  if (HasTruth(results)) {
    kinds.push_back(
        {MetricName("mAA", c) + ", higher is better", MetricName("mAA", c), 3, true, &PaperValue::accuracy});
    kinds.push_back({c.pixels ? "median error in pixels, lower is better" : "median error in degrees, lower is better",
                     c.pixels ? "median_px" : "median_deg", 3, false, &PaperValue::median_deg});
  } else {
    kinds.push_back({"median number of inliers (no ground truth)", "inliers", 0, true, nullptr});
  }
  std::vector<Table> tables;
  for (const Kind& kind : kinds) tables.push_back(MakeTable(results, kind));
  return tables;
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

std::string LatexTable(const Table& table) {
  const auto line = [](const std::vector<std::string>& cells) {
    std::string text = cells.front();
    for (std::size_t i = 1; i < cells.size(); ++i) text += " & " + cells[i];
    return text + " \\\\\n";
  };
  std::vector<std::string> heads;
  for (const std::string& column : table.columns) heads.push_back(LatexText(column));
  std::string text = "\\begin{tabular}{l" + std::string(table.columns.size() - 1, 'r') + "}\n\\toprule\n" +
                     line(heads) + "\\midrule\n";
  bool paper = false;
  for (const Table::Row& row : table.rows) {
    if (row.from_paper && !paper) text += "\\midrule\n";
    paper = paper || row.from_paper;
    std::vector<std::string> cells;
    for (std::size_t i = 0; i < row.cells.size(); ++i)
      cells.push_back(row.best[i] ? "\\textbf{" + LatexText(row.cells[i]) + "}" : LatexText(row.cells[i]));
    text += line(cells);
  }
  return text + "\\bottomrule\n\\end{tabular}\n";
}

std::string MarkdownReport(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  std::string text = "# " + (experiment.title.empty() ? experiment.name : experiment.title) + "\n\n";
  if (results.partial) text += "**Partial results: the run was interrupted.**\n\n";
  text += Setting(results) + ". Best in bold; references that are told more than the points (oracle) do not compete.\n";
  for (const Table& table : MakeTables(results)) text += "\n## " + table.heading + "\n\n" + MarkdownTable(table);
  text +=
      "\nhypotheses: models solved or scored, those of features and local optimisation included; ms: milliseconds a "
      "problem; both medians over all problems.\n";
  if (!experiment.paper.empty())
    text += "Rows marked \"paper, other data\" are the paper's figures; its data is not public.\n";
  if (!experiment.notes.empty()) text += "\n" + experiment.notes + "\n";
  return text;
}

std::string LatexReport(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  std::string text = "% Needs \\usepackage{booktabs}.\n";
  for (const Table& table : MakeTables(results)) {
    const std::string title = experiment.title.empty() ? experiment.name : experiment.title;
    text += "\\begin{table}[t]\n\\centering\n\\caption{" + LatexText(title) + ": " + LatexText(table.heading) + ". " +
            LatexText(Setting(results)) + (results.partial ? ". Partial results" : "") + ".}\n" + LatexTable(table) +
            "\\end{table}\n";
  }
  return text;
}

}  // namespace diffsac
