#pragma once

#include <optional>
#include <string>

#include "diffsac/problem/image_pair.h"

namespace diffsac {

/// The focal length that a JPEG file's EXIF data says, in pixels of an image of this size; either orientation, whatever
/// the orientation flag says, since sides are compared by their length.
///
/// From FocalLengthIn35mmFilm, which is by the diagonal (CIPA DCG-001): f₃₅ · diagonal / 43.27 mm; else from
/// FocalLength and the size of the sensor that Make and Model name (CropFactor); else from FocalLength and
/// FocalPlaneXResolution, in pixels of the image as it was taken. The order is COLMAP's. A reduced image has a reduced
/// focal length. Nothing: no JPEG, no EXIF data or damaged ones, no such fields or zeros in them, an image that was
/// cropped (of another shape than PixelXDimension and PixelYDimension say), and what no lens has (below a fifth of the
/// longer side, above fifty of them). Never throws: a focal length is a hint.
std::optional<double> ExifFocalPx(const std::string& path, const ImageSize& size);

/// Maker, model, focal length and size of an image as a JPEG file's EXIF data say them, in one text: images of which
/// all of it is the same are of one camera, at one zoom. Empty where a part is missing.
std::string ExifCamera(const std::string& path);

/// How far a camera's focal length is from what EXIF says, as a standard deviation of its logarithm: fields are whole
/// millimetres, and lenses breathe.
inline constexpr double kExifLogSigma = 0.1;

/// How many times the diagonal of a camera's sensor is shorter than that of 36 mm by 24 mm, by the maker and model that
/// EXIF data name. From the data of lensfun (https://lensfun.github.io), which knows about a thousand cameras; nothing
/// for others, and in a build without that library. Thread-safe.
std::optional<double> CropFactor(const std::string& maker, const std::string& model);

}  // namespace diffsac
