#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace diffsac {

/// A grey image in colour, a little lighter, so that what is drawn on it stands out.
cv::Mat LightImage(const cv::Mat& gray);

/// Writes the whole file, in the format that `path` ends in, marked as ours (lab/files/own_pictures.h). Throws Error as
/// CheckPictureName does, and where the file cannot be written.
void WritePicture(const cv::Mat& image, const std::string& path);

/// Throws Error unless WritePicture knows the format that `path` ends in, and where there is another's file already.
void CheckPictureName(const std::string& path);

}  // namespace diffsac
