#pragma once

#include <string>
#include <vector>

namespace diffsac {

/// The line at a page's end that tells a page as it was written from one that was changed by hand: SHA-256 of all
/// above.
std::string PageDigestLine(const std::string& text);

/// What is wrong with a page of results, a line each: it was changed since it was written, it is of a tree with changes
/// ("-dirty") or names no revision, or it has rows that its experiment has not. `config`: the table's configuration;
/// empty for pages of none, which need no digest. Throws Error where a file cannot be read.
std::vector<std::string> PageFaults(const std::string& page, const std::string& config);

}  // namespace diffsac
