#include "data_tools/run_pairs.h"

#include "data_tools/image_format.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

// Options that the format would not look at are mistakes.
void CheckRequest(const PairsRequest& request, const ImageFormat& format) {
  const GivenCalibration& given = request.calibration;
  if (given.IsGiven() && !format.takes_calibration)
    throw Error("--calibration, --focal and --center are for images without one; " + request.format + " has its own");
  if (format.takes_sequence && request.sequence.empty())
    throw Error("--sequence is needed for " + request.format + " (00, 01, ...)");
  if (!format.takes_sequence && !request.sequence.empty()) throw Error("--sequence is not for " + request.format);
  if (request.ratios && !format.takes_ratios) throw Error("--ratios is not for " + request.format);
  if (!request.choice.IsAll() && format.write)
    throw Error(request.input + ": the pairs of this format cannot be chosen");
}

}  // namespace

PrepareResult RunPairs(const PairsRequest& request, const std::atomic<bool>& stop) {
  const ImageFormat& format = Registry<ImageFormat>::Instance().Find(request.format, "--format");
  CheckRequest(request, format);
  if (format.write) return format.write(request, stop);
  ImageSource source = format.read(request);
  if (!format.chooses_pairs) ChoosePairs(request.choice, request.input, &source);
  RequireMotion(request.min_motion, request.input, &source);
  if (!request.scene.empty()) {
    if (source.scenes.size() != 1)
      throw Error("--scene: the source has " + std::to_string(source.scenes.size()) + " scenes");
    source.scenes[0].name = request.scene;
  }
  return PreparePairs(source, request.options, request.output, stop);
}

}  // namespace diffsac
