#include "diffsac/report/html_report.h"

#include <algorithm>
#include <filesystem>

#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/report/html_page.h"
#include "diffsac/report/pair_pictures.h"
#include "diffsac/report/plot_texts.h"
#include "diffsac/report/markdown_report.h"
#include "diffsac/report/svg_chart.h"
#include "diffsac/report/svg_fits.h"

namespace diffsac {

extern const char kReportJs[];

namespace {

constexpr std::size_t kMostLines = 30000;  // Of the list of problems.

void AddTables(const Report& report, HtmlPage* page) {
  page->AddSection("Tables");
  for (const Table& table : report.tables) page->AddTable(table);
  page->AddText(ReportNotes(report));
  if (!report.results.experiment.notes.empty()) page->AddText(report.results.experiment.notes);
}

LineChart AccuracyChart(const Report& report, const std::string& title, const std::string& x_label) {
  LineChart chart;
  chart.title = title;
  chart.x_label = x_label;
  chart.y_label = AccuracyTitle(report.results);
  chart.y_range = {0.0, 1.0};
  return chart;
}

void AddCurve(const Report& report, HtmlPage* page) {
  const ExperimentOptions& experiment = report.results.experiment;
  LineChart chart = AccuracyChart(report, "Accuracy by " + experiment.condition_label, experiment.condition_label);
  chart.curves = ConditionCurves(report);
  if (!experiment.figures.curve || chart.curves.empty()) return;
  chart.width = 660;
  chart.height = 420;
  page->AddSvg(SvgOf(chart), chart.y_label + ", higher is better, with 95 % intervals.");
}

void AddBars(const Report& report, HtmlPage* page) {
  const ExperimentOptions& experiment = report.results.experiment;
  BarChart chart;
  chart.title = "Accuracy of chosen rows";
  chart.y_label = AccuracyTitle(report.results);
  for (const std::size_t row : BarRows(experiment)) chart.rows.push_back(experiment.methods[row].label);
  chart.clusters = BarClusters(report, BarRows(experiment));
  const std::string svg = SvgOf(chart);
  if (svg.empty()) return;
  page->AddSvg(svg, chart.y_label + ", higher is better, with 95 % intervals" +
                        (JudgesPoses(report.results) ? "; R: of the rotation alone, t: of the translation alone." : "."));
}

void AddCosts(const Report& report, const std::string& cost, const std::string& title, const std::string& x_label,
              HtmlPage* page) {
  const ExperimentOptions& experiment = report.results.experiment;
  for (const CostPanel& panel : CostPanels(report, cost)) {
    LineChart chart = AccuracyChart(report, title, x_label);
    if (experiment.conditions.size() > 1)
      chart.title += ", " + experiment.condition_label + " " + experiment.conditions[panel.condition].label;
    chart.log_x = true;
    chart.curves = panel.curves;
    page->AddSvg(SvgOf(chart), chart.y_label + " against the median " + x_label + "; a curve joins budgets of one method.");
  }
}

bool HasFigures(const Report& report) {
  const ExperimentOptions& experiment = report.results.experiment;
  return (experiment.figures.curve && !ConditionCurves(report).empty()) ||
         !BarClusters(report, BarRows(experiment)).empty() || !CostPanels(report, "hypotheses").empty();
}

void AddFigures(const Report& report, HtmlPage* page) {
  if (!HasFigures(report)) return;
  page->AddSection("Curves and bars");
  AddCurve(report, page);
  AddBars(report, page);
  AddCosts(report, "hypotheses", "Accuracy by budget", "hypotheses (models solved or scored)", page);
  AddCosts(report, "ms_total", "Accuracy by time", "milliseconds", page);
}

void AddFits(const ExperimentResults& results, HtmlPage* page) {
  bool any = false;
  for (const KeptFit& fit : results.fits) {
    const std::string svg = SvgOfFit(fit);
    if (svg.empty()) continue;
    if (!any) page->AddSection("Fits");
    if (!any) page->AddMarkup("<div class=\"figures\">\n");
    any = true;
    page->AddSvg(svg, FitCaption(fit, results.experiment));
  }
  if (any) page->AddMarkup("</div>\n");
}

// Without them there is nothing to draw but points.
bool HasInliers(const ExperimentResults& results) {
  return !results.fits.empty() || std::any_of(results.cells.begin(), results.cells.end(),
                                              [](const Cell& cell) { return !cell.estimates.empty(); });
}

void AddProblems(const ExperimentResults& results, HtmlPage* page) {
  const bool pairs = IsTwoView(results.experiment.task);
  const ProblemList list = ListProblems(results);
  if (list.problems.empty()) return;
  page->AddSection(pairs ? "Pairs" : "Problems");
  std::vector<std::string> notes;
  PictureNumbers pictures;
  if (pairs && HasInliers(results)) {
    try {
      pictures = AddPairPictures(results, list, {}, page, &notes);
    } catch (const std::exception& error) {
      notes.push_back(std::string("There are no pictures of the pairs: ") + error.what());
      LogWarning("report.html has no pictures of the pairs: " + std::string(error.what()));
    }
  }
  std::size_t left_out = 0;
  page->AddJson("problems", ProblemListJson(results, list, pictures, kMostLines, &left_out));
  if (left_out > 0)
    notes.push_back(std::to_string(left_out) +
                    " lines are not in this list, which holds the largest, the smallest and evenly spread errors of each "
                    "method; problems.csv has them all.");
  for (const std::string& note : notes) page->AddText(note);
  page->AddMarkup("<div id=\"problem-list\"></div>\n");
  page->AddScript(kReportJs);
}

}  // namespace

std::string ReportHtml(const Report& report) {
  const ExperimentResults& results = report.results;
  const ExperimentOptions& experiment = results.experiment;
  HtmlPage page(PlotTitle(results));
  page.AddSubtitle(ReportSetting(results));
  page.AddSubtitle("diffsac_eval, revision " + results.git_revision + ", " + results.machine);
  if (results.partial) page.AddWarning("Partial results: the run was interrupted.");
  for (const std::string& row : experiment.left_out) page.AddText("Left out: " + row + ".");
  AddTables(report, &page);
  AddFigures(report, &page);
  AddFits(results, &page);
  AddProblems(results, &page);
  return page.Text();
}

void WriteReport(const Report& report, const std::string& folder) {
  const std::string path = (std::filesystem::path(folder) / kReportFile).string();
  if (!report.results.experiment.report) return RemoveFile(path);
  std::string text;
  try {
    text = ReportHtml(report);
  } catch (const std::exception& error) {
    LogWarning("no " + path + ": " + error.what());
    return RemoveFile(path);
  }
  WriteFileAtomically(path, text);
}

}  // namespace diffsac
