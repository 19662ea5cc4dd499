#pragma once

// Names of version 0.2 that changed in 0.3. Removed in 0.4. docs/versions.md lists the fields that changed, which have
// no alias. Included by diffsac.h.
#include "diffsac/diffsac.h"

namespace diffsac {

using CloudOptions [[deprecated("use RegistrationOptions")]] = RegistrationOptions;
using ScenePoints [[deprecated("use Matches2D3D")]] = Matches2D3D;
using CloudMatches [[deprecated("use Matches3D3D")]] = Matches3D3D;
using SharedFocalEstimate [[deprecated("use UnknownFocalEstimate")]] = UnknownFocalEstimate;
template <class Model>
using ModelsEstimate [[deprecated("use MultiModelEstimate")]] = MultiModelEstimate<Model>;

[[deprecated("use EstimateMultipleFundamentals")]] inline auto EstimateFundamentals(const Matches& matches,
                                                                                    const ImageOptions& options = {}) {
  return EstimateMultipleFundamentals(matches, options);
}
[[deprecated("use EstimateMultipleEssentials")]] inline auto EstimateEssentials(const Matches& matches,
                                                                                const CameraPair& cameras,
                                                                                const ImageOptions& options = {}) {
  return EstimateMultipleEssentials(matches, cameras, options);
}
[[deprecated("use EstimateMultipleHomographies")]] inline auto EstimateHomographies(const Matches& matches,
                                                                                    const ImageOptions& options = {}) {
  return EstimateMultipleHomographies(matches, options);
}
[[deprecated("use EstimateMultipleAbsolutePoses")]] inline auto EstimateAbsolutePoses(
    const Matches2D3D& matches, const Eigen::Matrix3d& K, const ImageOptions& options = {}) {
  return EstimateMultipleAbsolutePoses(matches, K, options);
}
[[deprecated("use EstimateMultipleRigidMotions")]] inline auto EstimateRigidMotions(
    const Matches3D3D& matches, const RegistrationOptions& options = {}) {
  return EstimateMultipleRigidMotions(matches, options);
}
[[deprecated("use EstimateMultipleLines")]] inline auto EstimateLines(const Points2DView& points,
                                                                      const PointOptions& options) {
  return EstimateMultipleLines(points, options);
}
[[deprecated("use EstimateMultiplePlanes")]] inline auto EstimatePlanes(const Points3DView& points,
                                                                        const PointOptions& options) {
  return EstimateMultiplePlanes(points, options);
}

}  // namespace diffsac
