#pragma once

#include <string>

#include "lab/options/options.h"

namespace diffsac {

/// An experiment as one plain document: what its author left to be put together is put together.
///
///   ${data_root}   in any text, or ${metric.threshold_px}: the plain value of that key; `data_root` is "data" unless given
///   seeds          [1, 2, 3]: `seed` is the first of these unless given
///   sweep          {outlier_ratio: [0.1, 0.2]}: a condition for each value of an option of the data
///   settings       {plain: {consensus: {...}}}: named parts of rows. A row, or another setting, names them by
///                  `use: plain` or `use: [network, plain]`: later ones override, and its own keys all of them
///   methods        {ransac: {type: ransac, ...}, ...}, a map of rows by name, which includes can add to and override;
///                  a list of rows with names is valid too
///   rows           names of `methods`: only these, in this order; without it all, of a map the oracle last.
///
/// Throws Error (file, line, nearest name).
Config ComposeExperiment(const Config& config);

}  // namespace diffsac
