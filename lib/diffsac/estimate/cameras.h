#pragma once

#include "diffsac/core/enum_names.h"

namespace diffsac {

/// Prior knowledge of the cameras of two images without calibration, for fundamental matrices. Needs sizes that are
/// equal.
enum class Cameras {
  kPhotographs,  ///< One camera: square pixels, principal point in the middle, usual focal length. The default.
  kUnknown,      ///< Nothing: pixels may have any shape.
};
/// Their names.
template <>
inline constexpr auto kEnumNames<Cameras> = NamesOf<Cameras>({{Cameras::kPhotographs, "photographs"},
                                                              {Cameras::kUnknown, "unknown"}});

}  // namespace diffsac
