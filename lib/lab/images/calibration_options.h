#pragma once

#include "lab/images/image_source.h"

namespace CLI {
class App;
}

namespace diffsac {

/// The options --calibration, --cameras, --focal and --center of programs that take photographs (ImageCameras).
void AddCalibrationOptions(CLI::App* app, GivenCalibration* calibration);

}  // namespace diffsac
