#pragma once

#include <functional>
#include <string>
#include <vector>

namespace diffsac {

/// The file of a scene's folder that holds small copies of its images, for pictures below the matches: by the image's
/// name the bytes of a JPEG file (uint8), its longest side at most kThumbnailSize pixels, the lens's distortion taken
/// out as it is from the matches. scripts/report reads it. Optional: scenes without it, and without some of the images,
/// are complete.
inline constexpr const char* kThumbnailsFile = "thumbnails.h5";
inline constexpr int kThumbnailSize = 640;

/// Writes the file, whole or not at all, with what `jpeg` gives for each image; images whose bytes are empty are left
/// out. Throws Error.
void WriteThumbnails(const std::string& folder, const std::vector<std::string>& images,
                     const std::function<std::string(std::size_t)>& jpeg);

}  // namespace diffsac
