#pragma once

#include "diffsac/core/enum_names.h"

namespace diffsac {

/// Prior knowledge of the cameras of two images without calibration, for fundamental matrices. Needs the images' sizes.
enum class Cameras {
  kPhotographs,  ///< Square pixels, principal points near the middle, focal lengths of about the size. The default.
  kUnknown,      ///< Nothing: pixels may have any shape.
};
/// Their names.
template <>
inline constexpr auto kEnumNames<Cameras> = NamesOf<Cameras>({{Cameras::kPhotographs, "photographs"},
                                                              {Cameras::kUnknown, "unknown"}});

}  // namespace diffsac
