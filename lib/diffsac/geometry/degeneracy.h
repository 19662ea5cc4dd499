#pragma once

#include "diffsac/core/enum_names.h"

namespace diffsac {

/// What two views say of the translation between them, or, where there are no cameras, of the model.
enum class Degeneracy {
  kNotTested,     ///< There is no model, or no such question: points, absolute poses, several models.
  kDetermined,    ///< They determine it.
  kPureRotation,  ///< The camera turned in place: any translation explains the matches.
  kStatic,  ///< The images show no motion: the same image, or what does not move with the scene (a watermark, dirt).
  kPlane,   ///< F: the matches lie on one plane, or the camera turned in place. They fit F with any epipole.
  kLine     ///< The matches lie on one line, or on one and a point or two: other models explain them as well.
};
/// Their names.
template <>
inline constexpr auto kEnumNames<Degeneracy> = NamesOf<Degeneracy>({{Degeneracy::kNotTested, "not_tested"},
                                                                    {Degeneracy::kDetermined, "determined"},
                                                                    {Degeneracy::kPureRotation, "pure_rotation"},
                                                                    {Degeneracy::kStatic, "static"},
                                                                    {Degeneracy::kPlane, "plane"},
                                                                    {Degeneracy::kLine, "line"}});

/// Whether the data leave it open.
inline bool IsUndetermined(Degeneracy degeneracy) {
  return degeneracy != Degeneracy::kNotTested && degeneracy != Degeneracy::kDetermined;
}

}  // namespace diffsac
