#pragma once

#include <string>

#include "lab/eval/experiment.h"

namespace diffsac {

/// What begins the line of a page that says how many seconds its run took.
inline constexpr const char* kRunSeconds = "time: ";

/// Writes a page (docs/results/NAME.md) of a run's folder: its table.md, its pictures, of those of matches two, copied
/// beside the page as NAME_*.png, `command`, which made it, and revision, seed, machine and date. Throws Error.
void WritePage(const std::string& folder, const std::string& page, const std::string& command);

/// Copies a picture beside a page as NAME_*.png; what shows it there, in Markdown.
std::string PictureBeside(const std::string& picture, const std::string& page, const std::string& name);

/// A run's revision, seed, machine and date, what it took, and digests of its data and networks, a line each.
std::string FactsOfRun(const std::string& folder);

/// Whether a folder holds what running the experiment would give: the whole results of the same configuration, newer
/// than this program and than the networks that rows name; and, where `page` is not empty, that the page is of this
/// run.
bool IsMade(const ExperimentOptions& experiment, const std::string& folder, const std::string& page);

}  // namespace diffsac
