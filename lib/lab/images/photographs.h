#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lab/images/image_source.h"

namespace diffsac {

/// Photographs and the pairs of them that are to be matched: one scene.
struct Photographs {
  ImageSource source;              ///< Without cameras and poses.
  std::string folder;              ///< That all of them are in.
  std::vector<std::string> files;  ///< By image: its path in that folder.
};

/// The photographs that a command line names: folders, files and patterns (* and ? in the last part of a path), each
/// once, in the order of their paths. All pairs of them; or those of `list` (PairChoice::pairs_file), whose images
/// these are where there are no `inputs`. Throws Error: a path that is not there, fewer than two images, what the list
/// says wrong. That a file is an image is not looked at.
Photographs ListPhotographs(const std::vector<std::string>& inputs, const std::string& list);

/// The folder that holds all of these absolute paths.
std::filesystem::path CommonFolder(const std::vector<std::filesystem::path>& files);

/// Whether these are two image files: what diffsac_pair shows as one pair.
bool AreTwoFiles(const std::vector<std::string>& inputs);

}  // namespace diffsac
