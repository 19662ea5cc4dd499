#include "diffsac/eval/tables.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "diffsac/eval/paper_table.h"

namespace diffsac {
namespace {

constexpr const char* kUnknown = "–";
constexpr std::size_t kMostConditionsTogether = 3;  // In a table that shows several metrics of each.

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

// One column of numbers: a metric of one condition and scene ("mean" and kAllPairs included).
struct Column {
  std::string heading;
  std::size_t condition = 0;
  std::string scene = "mean";
  std::string metric;
  int digits = 3;
  bool higher_is_better = true;
  double PaperValue::*paper = nullptr;
};

// What one table shows.
struct Kind {
  std::string heading;
  std::vector<Column> columns;
  bool costs = false;  // Hypotheses and milliseconds beside the numbers.
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

// The metrics of every cell are needed by many columns.
using CellNumbers = std::vector<std::vector<MetricValue>>;

CellNumbers AllMetrics(const ExperimentResults& results) {
  CellNumbers all;
  for (const Cell& cell : results.cells) all.push_back(CellMetrics(cell, results.experiment.tolerance()));
  return all;
}

std::vector<double> RowValues(const ExperimentResults& results, const CellNumbers& metrics, std::size_t method,
                              const std::vector<Column>& columns) {
  std::vector<double> values;
  for (const Column& column : columns) {
    double value = std::nan("");
    for (std::size_t i = 0; i < results.cells.size(); ++i)
      if (results.cells[i].method == method && results.cells[i].condition == column.condition)
        value = FindMetric(metrics[i], column.scene, column.metric);
    values.push_back(value);
  }
  return values;
}

// A row of numbers before the best are known.
struct NumberRow {
  std::vector<double> values;
  bool competes = true;
};

// Values that print the same are equally good.
void MarkBest(const std::vector<NumberRow>& numbers, const std::vector<Column>& columns, Table* table) {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    double best = std::nan("");
    for (const NumberRow& row : numbers) {
      const double value = row.values[c];
      if (!row.competes || std::isnan(value)) continue;
      if (std::isnan(best) || (columns[c].higher_is_better ? value > best : value < best)) best = value;
    }
    for (std::size_t r = 0; r < numbers.size(); ++r) {
      const std::string text = Fixed(numbers[r].values[c], columns[c].digits);
      table->rows[r].best[c + 1] =
          numbers[r].competes && !std::isnan(best) && text != kUnknown && text == Fixed(best, columns[c].digits);
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

void AddCosts(const ExperimentResults& results, std::size_t method, bool with_counts, Table::Row* row) {
  const double models =
      MedianOverAll(results, method, [](const ProblemRecord& r) { return double(r.report.hypotheses); });
  const double ms = MedianOverAll(results, method, [](const ProblemRecord& r) { return r.report.ms_total; });
  const bool oracle = results.experiment.methods[method].type == "oracle";
  row->cells.push_back(oracle ? kUnknown : Fixed(models, 0));
  row->cells.push_back(oracle ? kUnknown : General(ms));
  if (with_counts) row->cells.push_back(CountText(results, method));
}

void AddMethodRows(const ExperimentResults& results, const CellNumbers& metrics, const Kind& kind, bool with_counts,
                   Table* table) {
  std::vector<NumberRow> numbers;
  for (std::size_t m = 0; m < results.experiment.methods.size(); ++m) {
    if (!HasRecords(results, m)) continue;
    const MethodRow& method = results.experiment.methods[m];
    numbers.push_back({RowValues(results, metrics, m, kind.columns), method.Competes()});
    Table::Row row;
    row.cells.push_back(method.label);
    for (std::size_t c = 0; c < kind.columns.size(); ++c)
      row.cells.push_back(Fixed(numbers.back().values[c], kind.columns[c].digits));
    if (kind.costs) AddCosts(results, m, with_counts, &row);
    row.best.resize(row.cells.size());
    table->rows.push_back(std::move(row));
  }
  MarkBest(numbers, kind.columns, table);
}

// With the paper's digits: two, or three where it gives three.
std::string PaperText(double value) {
  const double hundredths = 100.0 * value;
  return Fixed(value, std::abs(hundredths - std::round(hundredths)) < 1e-6 ? 2 : 3);
}

void AddPaperRows(const ExperimentResults& results, const Kind& kind, Table* table) {
  for (const PaperRow& paper : results.experiment.paper) {
    Table::Row row;
    bool known = false;
    row.cells.push_back(paper.label + " (paper, other data)");
    for (const Column& column : kind.columns) {
      const auto found = paper.values.find(results.experiment.conditions[column.condition].name);
      const bool has_value = column.paper != nullptr && found != paper.values.end();
      const double value = has_value ? found->second.*column.paper : std::nan("");
      known = known || !std::isnan(value);
      row.cells.push_back(PaperText(value));
    }
    row.cells.resize(table->columns.size(), "");
    row.best.resize(row.cells.size());
    row.from_paper = true;
    if (known) table->rows.push_back(std::move(row));
  }
}

Table MakeTable(const ExperimentResults& results, const CellNumbers& metrics, const Kind& kind) {
  Table table;
  table.heading = kind.heading;
  table.columns.push_back("method");
  for (const Column& column : kind.columns) table.columns.push_back(column.heading);
  const bool with_counts = kind.costs && CountsDiffer(results);
  if (kind.costs) table.columns.insert(table.columns.end(), {"hypotheses", "ms"});
  if (with_counts) table.columns.push_back("n");
  AddMethodRows(results, metrics, kind, with_counts, &table);
  AddPaperRows(results, kind, &table);
  return table;
}

// A column for each condition.
void AddConditions(const ExperimentResults& results, const Column& one, const std::string& unit, Kind* kind) {
  const auto& conditions = results.experiment.conditions;
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    kind->columns.push_back(one);
    kind->columns.back().condition = c;
    kind->columns.back().heading = conditions[c].label + (unit.empty() ? "" : ": " + unit);
  }
}

// The scenes of a condition, in the order in which they first appear.
std::vector<std::string> Scenes(const ExperimentResults& results, std::size_t condition) {
  std::vector<std::string> scenes;
  for (const Cell& cell : results.cells) {
    if (cell.condition != condition) continue;
    for (const ProblemRecord& record : cell.records)
      if (std::find(scenes.begin(), scenes.end(), record.scene) == scenes.end()) scenes.push_back(record.scene);
  }
  return scenes;
}

std::size_t MostScenes(const ExperimentResults& results) {
  std::size_t most = 0;
  for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c)
    most = std::max(most, Scenes(results, c).size());
  return most;
}

bool HasSets(const ExperimentResults& results) {
  if (!IsTwoView(TaskFromString(results.experiment.task))) return false;
  for (const Cell& cell : results.cells)
    for (const ProblemRecord& record : cell.records)
      if (!std::isnan(record.all_inlier_sets)) return true;
  return false;
}

Kind AccuracyKind(const ExperimentResults& results, const std::string& scene, const std::string& note) {
  const std::string name = MetricName("mAA", results.experiment.tolerance());
  Kind kind{name + note + ", higher is better", {}, scene == "mean"};
  AddConditions(results, {"", 0, scene, name, 3, true, scene == "mean" ? &PaperValue::accuracy : nullptr}, "", &kind);
  return kind;
}

Kind MedianKind(const ExperimentResults& results) {
  const bool pixels = results.experiment.tolerance().pixels;
  Kind kind{std::string("median error in ") + (pixels ? "pixels" : "degrees") + ", lower is better", {}, true};
  AddConditions(results, {"", 0, "mean", pixels ? "median_px" : "median_deg", 3, false, &PaperValue::median_deg}, "",
                &kind);
  return kind;
}

// One table of several metrics; with many conditions, which would make it too wide, one table for each.
std::vector<Kind> KindsOf(const ExperimentResults& results, const std::string& heading_together,
                          const std::string& heading_apart, const std::vector<Column>& metrics) {
  std::vector<Kind> kinds;
  const bool together = results.experiment.conditions.size() <= kMostConditionsTogether;
  for (const Column& metric : metrics) {
    if (!together || kinds.empty())
      kinds.push_back({together ? heading_together : heading_apart + ", " + metric.heading, {}});
    AddConditions(results, metric, together ? metric.heading : "", &kinds.back());
  }
  return kinds;
}

// Rotation or translation alone: `letter` is R or t.
std::vector<Kind> PoseKinds(const ExperimentResults& results, const std::string& what, const std::string& letter) {
  const Tolerance c = results.experiment.tolerance();
  const bool rotation = letter == "R";
  return KindsOf(results, what + " alone", what + " alone",
                 {{MetricName("mAA", c), 0, "mean", MetricName("mAA_" + letter, c), 3, true,
                   rotation ? &PaperValue::rotation : &PaperValue::translation},
                  {"median degrees", 0, "mean", "median_" + letter + "_deg", 3, false,
                   rotation ? &PaperValue::median_rotation_deg : &PaperValue::median_translation_deg}});
}

// Two views: the area under the recall, and how often there was no model or no pose.
std::vector<Kind> AreaKinds(const ExperimentResults& results, bool poses) {
  std::vector<Tolerance> thresholds = {results.experiment.tolerance()};
  if (poses) thresholds = {Tolerance(5.0), Tolerance(10.0), Tolerance(20.0)};
  std::vector<Column> metrics;
  for (const Tolerance& threshold : thresholds)
    metrics.push_back({MetricName("AUC", threshold), 0, "mean", MetricName("AUC", threshold)});
  metrics.push_back({"failures", 0, "mean", "failures", 0, false});
  const std::string of = poses ? "max(R, t)" : "errors";
  return KindsOf(results, of + ": exact AUC and failures", of, metrics);
}

Kind SetsKind(const ExperimentResults& results) {
  Kind kind{"share of all-inlier sets among the first 20 minimal sets", {}};
  AddConditions(results, {"", 0, "mean", "all_inlier_sets"}, "", &kind);
  return kind;
}

Kind SceneKind(const ExperimentResults& results, std::size_t condition) {
  const std::string name = MetricName("mAA", results.experiment.tolerance());
  Kind kind{name + " by scene", {}};
  if (results.experiment.conditions.size() > 1)
    kind.heading += ", " + results.experiment.condition_label + " " + results.experiment.conditions[condition].label;
  for (const std::string& scene : Scenes(results, condition)) kind.columns.push_back({scene, condition, scene, name});
  return kind;
}

// "+0.208 [+0.154, +0.265]" for each comparison and condition; in bold where the interval leaves zero out.
Table DifferenceTable(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  Table table;
  table.heading = "differences in " + MetricName("mAA", experiment.tolerance()) + " with 95 % bootstrap intervals";
  table.columns.push_back("A minus B");
  for (const Condition& condition : experiment.conditions) table.columns.push_back(condition.label);
  for (const Comparison& pair : experiment.compare) {
    const std::size_t a = experiment.RowOf(pair.a), b = experiment.RowOf(pair.b);
    Table::Row row;
    row.cells.push_back(experiment.methods[a].label + " − " + experiment.methods[b].label);
    row.best.push_back(false);
    for (std::size_t c = 0; c < experiment.conditions.size(); ++c) {
      const auto difference = DifferenceOf(results, c, a, b);
      char text[80];
      if (difference)
        std::snprintf(text, sizeof(text), "%+.3f [%+.3f, %+.3f]", difference->mean, difference->low, difference->high);
      row.cells.push_back(difference ? text : kUnknown);
      row.best.push_back(difference && (difference->low > 0.0 || difference->high < 0.0));
    }
    table.rows.push_back(std::move(row));
  }
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

// What the networks of learned rows were made by; their hypotheses are in the first table.
Table LearnedTable(const ExperimentResults& results) {
  Table table;
  table.heading = "learned rows";
  table.columns = {"method", "parameters", "training problems", "of a run of", "began with"};
  for (const LearnedRow& row : results.learned) {
    const TrainingFacts& facts = row.facts;
    table.rows.push_back({{results.experiment.methods[row.method].label, std::to_string(facts.parameters),
                           std::to_string(facts.samples), std::to_string(facts.run_samples),
                           facts.start.empty() ? kUnknown : facts.start},
                          std::vector<bool>(5, false)});
  }
  return table;
}

}  // namespace

std::vector<Table> MakeTables(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  const std::size_t scenes = MostScenes(results);
  const bool truth = HasTruth(results), poses = JudgesPoses(results);
  std::vector<Kind> kinds;
  if (truth) {
    kinds.push_back(AccuracyKind(
        results, "mean", scenes > 1 ? ", unweighted mean over " + std::to_string(scenes) + " scenes" : std::string()));
    if (scenes > 1) kinds.push_back(AccuracyKind(results, kAllPairs, ", mean over all pairs"));
    kinds.push_back(MedianKind(results));
  } else {
    kinds.push_back({"median number of inliers (no ground truth)", {}, true});
    AddConditions(results, {"", 0, "mean", "inliers", 0}, "", &kinds.back());
  }
  const auto add = [&](const std::vector<Kind>& more) { kinds.insert(kinds.end(), more.begin(), more.end()); };
  if (poses) add(PoseKinds(results, "rotation", "R"));
  if (poses) add(PoseKinds(results, "translation", "t"));
  if (truth && IsTwoView(TaskFromString(experiment.task))) add(AreaKinds(results, poses));
  if (HasSets(results)) kinds.push_back(SetsKind(results));
  for (std::size_t c = 0; truth && c < experiment.conditions.size(); ++c)
    if (Scenes(results, c).size() > 1) kinds.push_back(SceneKind(results, c));
  const CellNumbers metrics = AllMetrics(results);
  std::vector<Table> tables;
  for (const Kind& kind : kinds) tables.push_back(MakeTable(results, metrics, kind));
  if (truth && !experiment.compare.empty()) tables.push_back(DifferenceTable(results));
  Table paper = PaperTable(results);
  if (!paper.rows.empty()) tables.push_back(std::move(paper));
  if (!results.learned.empty()) tables.push_back(LearnedTable(results));
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
      "problem; both medians over all problems.";
  if (MostScenes(results) > 1)
    text += " Medians of errors and AUC are unweighted means over the scenes, failures are sums.";
  if (!experiment.compare.empty())
    text +=
        " Differences: of the mean over scenes, pairs redrawn within their scene, both methods' values together; in "
        "bold where the interval leaves zero out.";
  text += "\n";
  if (!experiment.paper.empty())
    text += "Rows marked \"paper, other data\" are the paper's figures; its data is not public.\n";
  for (const std::string& row : experiment.left_out) text += "\nLeft out: " + row + ".\n";
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
