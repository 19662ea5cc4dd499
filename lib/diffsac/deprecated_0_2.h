#pragma once

// Names of version 0.2 that changed in 0.3. Removed in 0.4. docs/versions.md lists the fields that changed, which have
// no alias. Included by diffsac.h.
#include "diffsac/diffsac.h"

namespace diffsac {

/// RegistrationOptions.
using CloudOptions [[deprecated("use RegistrationOptions")]] = RegistrationOptions;
/// Matches2D3D.
using ScenePoints [[deprecated("use Matches2D3D")]] = Matches2D3D;
/// Matches3D3D.
using CloudMatches [[deprecated("use Matches3D3D")]] = Matches3D3D;
/// UnknownFocalEstimate.
using SharedFocalEstimate [[deprecated("use UnknownFocalEstimate")]] = UnknownFocalEstimate;
/// MultiModelEstimate.
template <class Model>
using ModelsEstimate [[deprecated("use MultiModelEstimate")]] = MultiModelEstimate<Model>;

/// EstimateMultipleFundamentals.
[[deprecated("use EstimateMultipleFundamentals")]] inline auto EstimateFundamentals(const Matches& matches,
                                                                                    const ImageOptions& options = {}) {
  return EstimateMultipleFundamentals(matches, options);
}
/// EstimateMultipleEssentials.
[[deprecated("use EstimateMultipleEssentials")]] inline auto EstimateEssentials(const Matches& matches,
                                                                                const CameraPair& cameras,
                                                                                const ImageOptions& options = {}) {
  return EstimateMultipleEssentials(matches, cameras, options);
}
/// EstimateMultipleHomographies.
[[deprecated("use EstimateMultipleHomographies")]] inline auto EstimateHomographies(const Matches& matches,
                                                                                    const ImageOptions& options = {}) {
  return EstimateMultipleHomographies(matches, options);
}
/// EstimateMultipleAbsolutePoses.
[[deprecated("use EstimateMultipleAbsolutePoses")]] inline auto EstimateAbsolutePoses(
    const Matches2D3D& matches, const Eigen::Matrix3d& K, const ImageOptions& options = {}) {
  return EstimateMultipleAbsolutePoses(matches, K, options);
}
/// EstimateMultipleRigidMotions.
[[deprecated("use EstimateMultipleRigidMotions")]] inline auto EstimateRigidMotions(
    const Matches3D3D& matches, const RegistrationOptions& options = {}) {
  return EstimateMultipleRigidMotions(matches, options);
}
/// EstimateMultipleLines.
[[deprecated("use EstimateMultipleLines")]] inline auto EstimateLines(const Points2DView& points,
                                                                      const PointOptions& options) {
  return EstimateMultipleLines(points, options);
}
/// EstimateMultiplePlanes.
[[deprecated("use EstimateMultiplePlanes")]] inline auto EstimatePlanes(const Points3DView& points,
                                                                        const PointOptions& options) {
  return EstimateMultiplePlanes(points, options);
}

}  // namespace diffsac
