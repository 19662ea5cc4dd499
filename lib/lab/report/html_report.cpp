#include "lab/report/html_report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "lab/eval/format.h"
#include "lab/eval/metrics.h"
#include "lab/eval/problem_quantities.h"
#include "lab/report/gnuplot.h"
#include "lab/report/html_page.h"
#include "lab/report/markdown_report.h"
#include "lab/report/match_kinds.h"
#include "lab/report/pair_pictures.h"
#include "lab/report/plot_texts.h"
#include "lab/report/plots.h"
#include "lab/report/words.h"

namespace diffsac {

extern const char kReportJs[];

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostListed = 30000;  // Of the list of problems.

void AddWords(const std::vector<Table>& tables, HtmlPage* page) {
  const auto words = WordsOf(tables);
  if (words.empty()) return;
  std::string html = "<details open><summary>What the columns mean</summary><dl class=\"words\">\n";
  for (const auto& [term, meaning] : words)
    html += "<dt>" + HtmlText(term) + "</dt><dd>" + HtmlText(meaning) + "</dd>\n";
  page->AddMarkup(html + "</dl></details>\n");
}

void AddTables(const Report& report, HtmlPage* page) {
  page->AddSection("Tables");
  page->AddMarkup("<div class=\"tables\">\n");
  for (const Table& table : report.tables) page->AddTable(table);
  page->AddMarkup("</div>\n");
  AddWords(report.tables, page);
  page->AddText(ReportNotes(report));
  if (!report.results.experiment.notes.empty()) page->AddText(report.results.experiment.notes);
}

/// What gnuplot drew of the run (lab/report/plots.h), in the order in which the page shows it.
struct Picture {
  std::string name;
  std::string caption;
};

std::vector<Picture> Pictures(const ExperimentResults& results) {
  const std::string accuracy = AccuracyTitle(results);
  const std::string joins = "; a curve joins budgets of one estimator.";
  std::vector<Picture> pictures = {
      {"curve", accuracy + ", higher is better."},
      {"bars", accuracy + ", higher is better, with 95 % intervals" +
                   (JudgesPoses(results) ? "; R: of the rotation alone, t: of the translation alone." : ".")},
      {"budget", accuracy + " against the median number of hypotheses" + joins},
      {"time", accuracy + " against the median milliseconds" + joins},
      {"reliability", "How often a point is an inlier, by the probability that was said of it."},
      {"effects", "What the levels of each factor add to " + accuracy +
                      " of the first, and by how much they multiply its milliseconds."}};
  for (const StrataOptions& strata : results.experiment.strata)
    pictures.push_back({StrataPicture(strata.by), accuracy + " by " + QuantityTitle(strata.by) +
                                                      "; below the bins, how many problems they have."});
  return pictures;
}

std::string PictureIn(const std::string& folder, const std::string& name) {
  const fs::path path = fs::path(folder) / (name + ".png");
  return !folder.empty() && fs::is_regular_file(path) ? ReadFile(path.string()) : "";
}

// A partial run's pictures are those of an earlier one.
void AddFigures(const Report& report, const std::string& folder, HtmlPage* page) {
  if (report.results.partial) return;
  bool any = false;
  for (const Picture& picture : Pictures(report.results)) {
    const std::string png = PictureIn(folder, picture.name);
    if (png.empty()) continue;
    if (!any) page->AddSection("Curves and bars");
    any = true;
    page->AddPicture(png, picture.caption);
  }
  if (!any && !folder.empty() && !HasGnuplot()) page->AddText("There are no pictures: gnuplot is not installed.");
}

std::string FitCaption(const KeptFit& fit, const ExperimentOptions& experiment) {
  std::string text = experiment.methods[fit.method].label + ", " + fit.example.id;
  if (experiment.conditions.size() > 1)
    text += ", " + experiment.condition_label + " " + experiment.conditions[fit.condition].label;
  if (fit.estimate.status != Status::kOk)
    return text + ": no model (" + std::string(ToString(fit.estimate.status)) + ")";
  const EstimateError errors = MeasureError(fit.estimate, fit.example);
  const double error = ShownError(errors, experiment.tolerance());
  const std::string unit = ShownUnit(!std::isnan(errors.recall), experiment.tolerance());
  if (!std::isnan(error)) text += Format(": error %.3g%s%s", error, unit == "°" ? "" : " ", unit.c_str());
  const auto points = static_cast<std::size_t>(fit.example.problem.points.rows());
  const MatchCounts counts = CountMatches(fit.estimate.inliers, fit.example.truth.inliers, points);
  if (fit.example.truth.inliers.empty()) return text + Format("; %d of %zu points are inliers", counts.right, points);
  return text + Format("; %zu points, inliers: %d right, %d wrong, %d missed", points, counts.right, counts.wrong,
                       counts.missed);
}

// Two views have theirs in the list of pairs.
void AddFits(const ExperimentResults& results, const std::string& folder, HtmlPage* page) {
  if (results.fits.empty() || IsTwoView(results.experiment.task)) return;
  page->AddSection("Fits");
  const std::string png = results.partial ? "" : PictureIn(folder, "fits");
  if (!png.empty()) page->AddPicture(png, "The kept fits, a column a condition.");
  for (const KeptFit& fit : results.fits) page->AddText(FitCaption(fit, results.experiment));
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
  page->AddJson("problems", ProblemListJson(results, list, pictures, kMostListed, &left_out));
  if (left_out > 0)
    notes.push_back(
        std::to_string(left_out) +
        " lines are not in this list, which holds the largest, the smallest and evenly spread errors of each "
        "method; problems.csv has them all.");
  for (const std::string& note : notes) page->AddText(note);
  page->AddMarkup("<div id=\"problem-list\"></div>\n");
  page->AddScript(kReportJs);
}

}  // namespace

std::string ReportHtml(const Report& report, const std::string& folder) {
  const ExperimentResults& results = report.results;
  const ExperimentOptions& experiment = results.experiment;
  HtmlPage page(PlotTitle(results));
  page.AddSubtitle(ReportSetting(results));
  page.AddSubtitle("diffsac_eval, revision " + results.git_revision + ", " + results.machine);
  if (results.partial) page.AddWarning("Partial results: the run was interrupted.");
  for (const std::string& row : experiment.left_out) page.AddText("Left out: " + row + ".");
  AddTables(report, &page);
  AddFigures(report, folder, &page);
  AddFits(results, folder, &page);
  AddProblems(results, &page);
  return page.Text();
}

void WriteReport(const Report& report, const std::string& folder) {
  const std::string path = (std::filesystem::path(folder) / kReportFile).string();
  if (!report.results.experiment.report) return RemoveFile(path);
  std::string text;
  try {
    text = ReportHtml(report, folder);
  } catch (const std::exception& error) {
    LogWarning("no " + path + ": " + error.what());
    return RemoveFile(path);
  }
  WriteFileAtomically(path, text);
}

}  // namespace diffsac
