#pragma once

#include <string>

#include "data_tools/image_source.h"

namespace diffsac {

/// A small copy of an image (io/thumbnails.h), a JPEG file's bytes: reduced to kThumbnailSize, without the distortion
/// of its lens where the source knows the camera. Empty for a file that is no image.
std::string ThumbnailOf(const SourceImage& image);

}  // namespace diffsac
