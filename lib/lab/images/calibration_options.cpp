#include "lab/images/calibration_options.h"

#include <CLI/CLI.hpp>

namespace diffsac {

void AddCalibrationOptions(CLI::App* app, GivenCalibration* calibration) {
  app->add_option_function<std::vector<std::string>>(
         "--calibration",
         [calibration](const std::vector<std::string>& files) {
           if (files.size() == 1)
             calibration->file = files[0];
           else
             calibration->files = files;
         },
         "A file with the 3x3 matrix K of all images, or one for each, as a.txt,b.txt (default: none; the focal length "
         "is looked for in EXIF data)")
      ->delimiter(',')
      ->allow_extra_args(false);
  app->add_option("--cameras", calibration->cameras,
                  "COLMAP's cameras of the images: the folder of a model, or a file cameras.txt; any camera model, and "
                  "its distortion is taken out (default: none)");
  app->add_option("--focal", calibration->focal, "Focal length of all images, in pixels (default: unknown)");
  app->add_option("--center", calibration->center, "Principal point, as 320,240 (default: each image's middle)")
      ->delimiter(',');
}

}  // namespace diffsac
