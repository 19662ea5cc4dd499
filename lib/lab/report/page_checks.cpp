#include "lab/report/page_checks.h"

#include <set>

#include "diffsac/core/files.h"
#include "lab/eval/digest.h"
#include "lab/report/command_line.h"
#include "lab/report/page_tables.h"

namespace diffsac {
namespace {

constexpr const char* kDigest = "- page: sha256 ";
constexpr const char* kPaperRows[] = {" (paper, other data)", " (published)"};

std::set<std::string> RowsOf(const std::string& config) {
  EvalRequest request;
  request.config_path = config;
  const ExperimentOptions experiment = ReadRequest(request);
  std::set<std::string> rows;
  for (const EstimatorRow& row : experiment.methods) rows.insert(row.label);
  for (const auto& [label, values] : experiment.paper)
    for (const char* suffix : kPaperRows) rows.insert(label + suffix);
  return rows;
}

void AddUnknownRows(const ResultsPage& page, const std::string& config, std::vector<std::string>* faults) {
  const std::set<std::string> rows = RowsOf(config);
  std::set<std::string> unknown;
  for (const PageTable& table : page.tables)
    for (const auto& row : table.rows)
      if (table.columns.front() == "method" && rows.count(row.front()) == 0) unknown.insert(row.front());
  for (const std::string& row : unknown) faults->push_back(page.path + ": " + config + " has no row '" + row + "'");
}

}  // namespace

std::string PageDigestLine(const std::string& text) { return kDigest + DigestOfText(text) + "\n"; }

std::vector<std::string> PageFaults(const std::string& path, const std::string& config) {
  std::vector<std::string> faults;
  const std::string text = ReadFile(path);
  const std::size_t digest = text.find(kDigest);
  if (digest == std::string::npos && !config.empty())
    faults.push_back(path + ": has no digest of its text; it is of an older program");
  if (digest != std::string::npos && text.substr(digest) != PageDigestLine(text.substr(0, digest)))
    faults.push_back(path + ": was changed after it was written");
  const ResultsPage page = ReadResultsPage(path);
  if (page.revision.empty()) faults.push_back(path + ": names no revision");
  if (page.revision.ends_with("-dirty")) faults.push_back(path + ": is of a tree with changes, " + page.revision);
  if (!config.empty()) AddUnknownRows(page, config, &faults);
  return faults;
}

}  // namespace diffsac
