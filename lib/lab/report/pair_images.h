#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/problem/problem.h"
#include "lab/eval/experiment.h"

namespace diffsac {

/// The names of a pair's images: those that the example has, or what its id "scene/img1-img2" says; empty for another.
std::pair<std::string, std::string> ImageNames(const Example& example);

/// The extent of a canvas for an image's points (columns `column` and the next): the image's size, or else the box of
/// its points from (0, 0) on.
ImageSize CanvasSize(const ImageSize& known, const PointMatrix& points, int column);

/// The file of an image by the scene's folder (`figures.images`), whatever its extension; empty when there is none,
/// which `warn` says in the log.
std::string ImageFile(const std::vector<ImageFolder>& folders, const std::string& scene, const std::string& image,
                      bool warn = true);

/// An image in colour, about as large as `longest` or larger: the file's in `figures.images`, or else the small copy in
/// the scene's folder (lab/files/thumbnails.h). Empty where there is none or it cannot be read. `size`: of the image,
/// or unknown.
cv::Mat LoadImageOf(const std::vector<ImageFolder>& folders, const std::string& scene, const std::string& scene_folder,
                    const std::string& image, const ImageSize& size, int longest);

}  // namespace diffsac
