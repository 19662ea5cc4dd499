#pragma once

#include <atomic>
#include <iosfwd>

#include "lab/report/command_line.h"

namespace diffsac {

/// Whether the experiment's `sweep` asks for whole runs (sweep.h). Throws Error.
bool IsSweep(const EvalRequest& request);

/// Runs every point of the sweep in a folder of its own, FOLDER/points/hypotheses=100,score=msac, passes over those
/// that are made already, and writes the table of all to FOLDER. Returns what Evaluate returns; interrupted, the same
/// call goes on. Throws Error.
int EvaluateSweep(const EvalRequest& request, const TraceConfidence& trace, const std::atomic<bool>& stop,
                  std::ostream& out);

}  // namespace diffsac
