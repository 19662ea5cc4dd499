#pragma once

#include <string>
#include <utility>
#include <vector>

#include "lab/report/report.h"

namespace diffsac {

/// What the headings and columns of these tables mean, for somebody who sees them first: term and meaning, those that
/// occur. Exact definitions are in docs/metrics.md.
std::vector<std::pair<std::string, std::string>> WordsOf(const std::vector<Table>& tables);

}  // namespace diffsac
