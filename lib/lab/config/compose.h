#pragma once

#include <string>

#include "lab/options/options.h"

namespace diffsac {

/// An experiment as one plain document: what its author left to be put together is put together.
///
///   ${data_root}   in any text, or ${metric.threshold_px}: the plain value of that key; `data_root` is "data" unless
///                  given
///   seeds          [1, 2, 3]: `seed` is the first of these unless given
///   sweep          {outlier_ratio: [0.1, 0.2]}: a condition for each value of an option of the data
///   methods        {ransac: {type: ransac, ...}, ...} by name, which includes can add to and override; a list of rows
///                  with names is valid too. One without `type` and `preset` takes the preset of its own name
///   presets        {plain: {consensus: {...}}}: named parts of methods. A method, or another preset, names them by
///                  `preset: plain` or `preset: [network, plain]`: later ones override, and its own keys all of them. A
///                  name that is not there is one of the method's type (`recommended`)
///   sweep          of a method: {max_iterations: [10, 100]}, rows NAME_10 and NAME_100; {order: {uniform: {...},
///                  ratio: {...}}}, rows NAME_uniform and NAME_ratio with these parts; of several keys all
///                  combinations. A `*` in the label stands for a level; a label without ends in it
///
/// Throws Error (file, line, nearest name).
Config ComposeExperiment(const Config& config);

}  // namespace diffsac
