#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// Models that another program estimated of the same problems: a table of text as scripts/peers/two_view.py writes it.
/// `seed`: that of the experiment; a file that has fewer gives those that it has in turn. `model`: in the form of
/// estimates.h5 (docs/estimates.md); empty: no estimate.
struct RecordedOptions {
  std::string recording;
  std::string row;
  void Bind(OptionsBinder& b);
};

/// A row of such a file: what it has of the problem that is asked for. Inliers are those of ε under the model.
class RecordedRow {
 public:
  /// Throws Error, with the file and the line, for what is no such file or has not this row.
  explicit RecordedRow(const RecordedOptions& options);

  /// The estimate of one problem. Throws Error where the file does not name it.
  Estimate Of(const Example& example, const std::string& condition, std::uint64_t seed) const;

 private:
  struct Record {
    double ms = 0.0;
    ModelParameters model;
  };

  RecordedOptions options_;
  std::map<std::tuple<std::string, std::string, std::uint64_t>, Record> records_;  // By condition, id and seed.
  std::set<std::uint64_t> seeds_;
};

}  // namespace diffsac
