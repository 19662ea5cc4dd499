#pragma once

#include <string>
#include <vector>

#include "lab/data/point_files.h"
#include "lab/eval/results.h"

namespace diffsac {

/// The folder, in a run's folder, of the labels of a person's own points (data of type point_sets).
inline constexpr const char* kLabelsFolder = "labels";

/// What one estimator made of the points of a file.
struct PointLabels {
  std::string method;
  std::vector<std::int32_t> labels;  ///< One a point of the file: 0 for an outlier, 1 for an inlier, or of structure k.
};

/// One label for each point of the file that `record` is of. Points that the estimator was not given (max_points) are
/// those of the nearest model within the estimate's inlier threshold; `threshold` stands for one that it does not tell.
std::vector<std::int32_t> LabelsOf(const EstimateRecord& record, const PointMatrix& points, double threshold);

/// x,y[,z] of every point as it was read, a column of labels a method, and, where some points were left out of the
/// problem, `used`. `rows` as in PointSource.
std::string LabelsCsv(const PointMatrix& points, const std::vector<PointLabels>& methods,
                      const std::vector<std::int32_t>& rows);

/// The same as a binary PLY file of coloured points: green inliers, or a colour a structure, of the method at `shown`;
/// label_METHOD has each method's labels.
std::string LabelsPly(const PointMatrix& points, const std::vector<PointLabels>& methods, std::size_t shown,
                      const std::vector<std::int32_t>& rows);

/// Writes a file of labels for each input of point_sets data into `folder`/labels, for the first `labels` inputs of the
/// experiment; those of an earlier run go. Inputs that cannot be read any more are a warning. Throws Error when a file
/// cannot be written.
void WriteLabels(const ExperimentResults& results, const std::string& folder);

}  // namespace diffsac
