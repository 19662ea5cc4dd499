#pragma once

#include <string>

#include "lab/options/options.h"

namespace diffsac {

/// An experiment as one plain document: `${key}`, `seeds`, `sweep`, `presets` and methods by name, which
/// docs/configuration.md describes, are put together.
/// Throws Error (file, line, nearest name).
Config ComposeExperiment(const Config& config);

}  // namespace diffsac
