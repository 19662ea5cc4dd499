#pragma once

#include "lab/eval/report.h"

namespace diffsac {

/// Ours beside the paper's, for rows of `paper` that name one of ours (`ours: METHOD`): condition, metric, the paper's
/// value, ours with its 95 % bootstrap interval over the problems, the difference, and the number of problems. The data
/// differ, which the report says. No rows where nothing is named or known.
Table PaperTable(const Report& report);

}  // namespace diffsac
