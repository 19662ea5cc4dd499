#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "diffsac/core/options.h"
#include "diffsac/data/problem.h"

namespace diffsac {

/// Builds a dataset from YAML. The key `type` chooses it, the other keys are its options:
///   synthetic_line, synthetic_plane   SyntheticOptions (data/synthetic.h)
///   synthetic_two_view                SyntheticTwoViewOptions (data/synthetic_two_view.h)
///   modelnet40                        ModelnetOptions (data/modelnet.h)
///   point_sets                        PointSetsOptions (data/point_files.h)
///   correspondences                   CorrespondencesOptions (data/two_view_dataset.h)
///   ransac_tutorial, kitti            RansacTutorialOptions, KittiOptions (data/tutorial_dataset.h)
/// `seed` decides synthetic data. Throws Error: file, line, nearest valid key or type.
std::unique_ptr<Dataset> MakeDataset(const Config& config, std::uint64_t seed);

/// The resolved options, `type` included, as YAML. Throws as MakeDataset does.
std::string WriteDatasetOptions(const Config& config);

}  // namespace diffsac
