#pragma once

#include <string>
#include <vector>

#include "lab/ground_truth/example.h"
#include "lab/images/image_source.h"

namespace diffsac {

/// A small copy of an image (lab/files/thumbnails.h), a JPEG file's bytes: reduced to kThumbnailSize, without the
/// distortion of its lens where the source knows the camera. Empty for a file that is no image.
std::string ThumbnailOf(const SourceImage& image);

/// The small copies of the images that the pairs name, as the file of a scene's folder (WriteThumbnails), on up to
/// `threads` threads (0: all cores). Throws Error.
void WriteThumbnailsOf(const ImageSource& source, const std::vector<Example>& pairs, int threads,
                       const std::string& folder);

}  // namespace diffsac
