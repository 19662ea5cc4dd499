#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lab/images/image_source.h"

namespace CLI {
class App;
}

namespace diffsac {

/// The cameras of photographs whose calibration is given: one K for all, one for each, a focal length with the image's
/// middle, or COLMAP's cameras, which are found by the images' names.
class ImageCameras {
 public:
  /// `paths`: of the images. Files are read here, before any work. Throws Error: what CameraOf says; another number of
  /// files than one or that of the images; several of COLMAP's cameras without images.txt, which says whose they are.
  ImageCameras(const GivenCalibration& calibration, const std::vector<std::string>& paths);

  /// Whether there is a calibration at all.
  bool given() const { return given_.IsGiven(); }
  /// The camera of an image whose size is known now; none without a calibration. Throws Error naming the image:
  /// COLMAP's model does not have it, or its camera has another size; or naming the calibration, where it would see
  /// nearly 180 degrees of that size. Warns, once, of a principal point far from the image's middle.
  std::optional<LensCamera> Of(std::size_t image, const ImageSize& size) const;

  /// Warns of one K for images of several sizes: most likely some of them were turned, or another camera took them; and
  /// of one focal length, unless they were turned.
  void WarnOfSizes(const std::vector<ImageSize>& sizes) const;

 private:
  void ReadColmap();
  std::string NameOf(std::size_t image) const;  // Of what gave its calibration.

  GivenCalibration given_;
  std::vector<std::string> paths_;
  std::map<std::string, std::string> left_out_;     // Of COLMAP's images by their names: why.
  std::vector<std::optional<LensCamera>> cameras_;  // As paths_; none: not known, or by its size.
};

/// What EXIF data say of an image's camera (ExifFocalPx), where no calibration is given.
CameraPriorHint ExifHint(const std::string& path, const ImageSize& size);

/// The options --calibration, --cameras, --focal and --center of programs that take photographs (ImageCameras).
void AddCalibrationOptions(CLI::App* app, GivenCalibration* calibration);

}  // namespace diffsac
