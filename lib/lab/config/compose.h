#pragma once

#include <string>

#include "diffsac/core/options.h"

namespace diffsac {

/// An experiment as one plain document: what its author left to be put together is put together.
///
///   alternatives   a list of documents, each with `needs`, a list of files or folders: the first of which one of these
///   is
///                  there (or that needs nothing; else the first of all) is put under the experiment. Passed over where
///                  the experiment gives `data.paths` itself
///   ${data_root}   in any text, or ${figures.curve}: the plain value of that key; `data_root` is "data" unless given
///   sweep          {outlier_ratio: [0.1, 0.2]}: a condition for each value of an option of the data. Keys with a dot
///                  are whole runs, not this function's (sweep.h)
///   settings       {plain: {consensus: {...}}}: named parts of rows. A row, or another setting, names them by
///                  `use: plain` or `use: [network, plain]`: later ones override, and its own keys all of them
///   methods        {ransac: {type: ransac, ...}, ...}, a map of rows by name, which includes can add to and override;
///                  a list of rows with names is valid too
///   hypotheses     of a row, as a list [10, 100]: a row each, NAME_10 and NAME_100, labels LABEL 10 and LABEL 100,
///   which
///                  are a `series` in the pictures of budgets, by the name LABEL unless the row says another
///   factors        {score: {msac: {...}, counted: {...}}, draws: {"100": {...}, ...}}: a row for each combination of
///                  levels, over `factors_base` (compose_factors.h)
///   rows           names of `methods`: only these, in this order; without it all, of a map the oracle last. What the
///                  experiment says of the others elsewhere (compare, figures, paper, reference) goes with them
///   compare        {a: [b, c]} for [[a, b], [a, c]]
///   strata         a map for a list of one
///
/// Throws Error (file, line, nearest name).
Config ComposeExperiment(const Config& config);

}  // namespace diffsac
