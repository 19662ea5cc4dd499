#include "lab/images/picture.h"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/files/own_pictures.h"

namespace diffsac {

cv::Mat LightImage(const cv::Mat& gray) {
  cv::Mat light, color;
  gray.convertTo(light, CV_8U, 0.7, 60.0);
  cv::cvtColor(light, color, cv::COLOR_GRAY2BGR);
  return color;
}

void CheckPictureName(const std::string& path) {
  if (std::filesystem::path(path).extension().empty() || !cv::haveImageWriter(path))
    throw Error(path + ": expected a name that ends in .png, .jpg or another format of pictures");
  RefuseOtherPicture(path);
}

void WritePicture(const cv::Mat& image, const std::string& path) {
  CheckPictureName(path);
  std::vector<unsigned char> encoded;
  cv::imencode(std::filesystem::path(path).extension().string(), image, encoded);
  WriteFileAtomically(path, MarkedAsOwn({reinterpret_cast<const char*>(encoded.data()), encoded.size()}));
}

}  // namespace diffsac
