#pragma once

#include <string>

#include "lab/report/report.h"

namespace diffsac {

/// The file of a run folder that is there to be looked at.
inline constexpr const char* kReportFile = "report.html";

/// A page that needs no network and no other file: the tables, to be sorted, with intervals; the pictures that
/// DrawFigures (lab/report/plots.h) left in `folder`, where one is given; and every problem by its error, those of two
/// views with a picture of their matches (docs/report.md). The conditions' data is read again for these.
std::string ReportHtml(const Report& report, const std::string& folder = "");

/// Writes it into the run's folder, or removes that of an earlier run where the experiment has none. That it
/// cannot be made is a warning in the log: the results are there already. Throws Error when it cannot be written.
void WriteReport(const Report& report, const std::string& folder);

}  // namespace diffsac
