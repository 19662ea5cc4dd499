#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/problem/tasks.h"
#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// One point set as it stands in a file.
struct PointSet {
  std::string name;          ///< The file's.
  std::string scene;         ///< The name of the folder that holds it.
  PointMatrix points;        ///< N × 2 or N × 3; NaN and infinities are kept.
  std::string columns = {};  ///< The names in a text file's header, for messages: "'id', 'x', 'y'".
};

/// Reads a file by its extension, .ply or .csv .txt .xyz .dat .tsv. All readers throw Error naming the file (and the
/// line).
std::vector<PointSet> ReadPointFile(const std::string& path);

/// The columns of a text file, by the names that a header gives them; without a header in this order.
struct TextColumns {
  std::string what;  ///< What a row is, for messages: "points".
  std::vector<std::string> needed, optional;
};

struct TextTable {
  PointMatrix values;              ///< A column for each of `names`.
  std::vector<std::string> names;  ///< The needed ones, then those of the optional that there are.
  std::string header;              ///< The names in the header as they stand there, for messages; empty without one.
};

/// Numbers in text, as ReadTextPoints has them.
TextTable ReadTextTable(const std::string& path, const TextColumns& columns);

/// Text: 2 or 3 numbers a line (docs/points.md). Under a header empty values and "NA" are NaN; without x and y in it
/// all columns are taken in their order but those that count the rows (id, index, #, no name).
PointSet ReadTextPoints(const std::string& path);

/// PLY, ascii or binary of either byte order: the properties x, y and (unless absent) z, of any scalar type, of the
/// element `vertex`. Other properties, lists and elements are skipped.
PointSet ReadPlyPoints(const std::string& path);

/// A user's own points as a dataset.
struct PointSetsOptions {
  std::vector<std::string> paths;
  Task task = Task::kLine;
  double inlier_threshold = 0.0;
  double inlier_threshold_relative = 0.0;
  std::string unit;
  int max_points = 0;
  std::uint64_t seed = 0;
  void Bind(OptionsBinder& b);
};

/// Whether a file is text (one of the extensions above).
bool IsTextPointFile(const std::string& path);

/// Whether the configuration of a data set is one of these (type: point_sets).
bool IsPointSets(const Config& data);

/// Reads everything at once, so `Get` is a copy. The data set has PointSources. Throws Error.
std::unique_ptr<Dataset> MakePointSets(const PointSetsOptions& options);

/// Where the points of a problem come from.
struct PointSource {
  std::string path;  ///< The file.
  std::string name;  ///< PointSet::name.
  /// Which of the file's points the problem has, ascending; empty: all of them.
  std::vector<std::int32_t> rows;
  std::int64_t total = 0;  ///< Points in the file.
};

/// What data of files has beside Dataset: it can say where a problem's points come from.
class HasPointSources {
 public:
  virtual ~HasPointSources() = default;
  /// Of the example at a place, from 0.
  virtual const PointSource& SourceOf(std::uint64_t index) const = 0;
};

}  // namespace diffsac
