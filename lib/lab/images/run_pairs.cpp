#include "lab/images/run_pairs.h"

#include <filesystem>

#include "diffsac/core/status.h"

namespace diffsac {

namespace fs = std::filesystem;

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

void RefuseInputsInScene(const PairsRequest& request, const std::string& folder) {
  std::error_code code;
  for (const fs::path input : {request.input, request.options.import_descriptors}) {
    const fs::path holder = fs::absolute(input, code).parent_path();
    if (!input.empty() && input.extension() == ".h5" && fs::equivalent(holder, folder, code))
      throw Error("'" + input.string() + "' is an input, and would be replaced in the folder of the scene '" + folder +
                  "': give another --output or --scene");
  }
}

PrepareResult RunPairs(const PairsRequest& request, const std::atomic<bool>& stop) {
  const ImageFormat& format = Registry<ImageFormat>::Instance().Find(request.format, "--format");
  CheckRequest(request, format);
  if (format.write) return format.write(request, stop);
  ImageSource source = format.read(request);
  if (!format.chooses_pairs) ChoosePairs(request.choice, request.input, &source);
  if (!request.scene.empty()) {
    if (source.scenes.size() != 1)
      throw Error("--scene: the source has " + std::to_string(source.scenes.size()) + " scenes");
    source.scenes[0].name = request.scene;
  }
  for (const SourceScene& scene : source.scenes)
    RefuseInputsInScene(request, (fs::path(request.output) / scene.name).string());
  return PreparePairs(source, request.options, request.output, stop);
}

}  // namespace diffsac
