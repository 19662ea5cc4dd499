// Vanishing points of photographs: line segments, focal length and horizon, as a text and a picture.
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <optional>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/diffsac.h"
#include "lab/config/process.h"
#include "lab/config/program.h"
#include "lab/config/progress.h"
#include "lab/config/run_directory.h"
#include "lab/files/files.h"
#include "lab/images/image_source.h"
#include "lab/images/pictures.h"
#include "lab/images/vanishing_text.h"

namespace {

using namespace diffsac;
namespace fs = std::filesystem;

struct Request {
  std::vector<std::string> images;
  std::string picture = "diffsac_pictures/vanishing_points.png", json, estimates, segments;
  GivenCalibration calibration;
  VanishingPointOptions options;
  int max_image_size = 1200;
};

void AddOptions(CLI::App* app, Request* request) {
  VanishingPointOptions& options = request->options;
  app->add_option("images", request->images, "Image files")->required();
  app->add_option("--calibration", request->calibration.file, "A file with the 3x3 matrix K of the images");
  app->add_option("--focal", request->calibration.focal,
                  "Focal length of the images, in pixels (default: EXIF's, or found from the vanishing points)")
      ->check(NumberAbove(0));
  app->add_option("--center", request->calibration.center,
                  "With --focal: the principal point, as 320,240 (default: the middle)")
      ->delimiter(',');
  app->add_option("--max-image-size", request->max_image_size,
                  "Reduce larger images to this side before segments are looked for; 0: never")
      ->check(NumberFrom(0))
      ->capture_default_str();
  app->add_option("--threshold-deg", options.max_residual_deg,
                  "A segment is of a vanishing point that it points at within this angle")
      ->check(NumberWithin(0.01, 90.0))
      ->capture_default_str();
  app->add_option("--least-value", options.least_value,
                  "The list ends where the network is less sure than this; 0: eight vanishing points")
      ->check(NumberWithin(0.0, 1.0))
      ->capture_default_str();
  app->add_flag_callback(
      "--no-network", [&options] { options.guidance = Guidance::kNone; }, "Choose by the length of the segments alone");
  app->add_option("--picture", request->picture,
                  "Where the picture goes; empty: none. Of several images each has its name added")
      ->capture_default_str();
  app->add_option("--json", request->json, "Also everything as JSON in this file");
  app->add_option("--estimates", request->estimates, "Also everything, with the segments, in this HDF5 file");
  app->add_option("--segments", request->segments,
                  "Also the segments in this file, a line each: x1 y1 x2 y2 and the number of its vanishing point");
  app->add_option("--seed", options.seed, "Of the search")->check(NumberFrom(0))->capture_default_str();
}

/// Of several images "points.png" becomes "points_NAME.png".
std::string FileOf(const std::string& path, const std::string& name, bool several) {
  if (!several) return path;
  const fs::path file(path);
  return (file.parent_path() / (file.stem().string() + "_" + name + file.extension().string())).string();
}

double MillisecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

VanishingImage Find(const std::string& path, const Photograph& photograph, const Request& request) {
  VanishingImage found;
  const auto start = std::chrono::steady_clock::now();
  found.image = DetectSegments(photograph.gray, request.max_image_size);
  found.ms_segments = MillisecondsSince(start);
  found.image.name = ImageName(path);
  found.image.K = photograph.K;
  found.exif = photograph.exif;
  VanishingPointOptions options = request.options;
  options.K = photograph.K;
  options.size = found.image.size;
  found.estimate = EstimateVanishingPoints(found.image.segments, options);
  return found;
}

VanishingImage Treat(const std::string& path, const Photograph& photograph, const Request& request) {
  const bool several = request.images.size() > 1;
  VanishingImage found = Find(path, photograph, request);
  std::cout << VanishingText(found) << std::flush;
  const std::string& name = found.image.name;
  if (!request.segments.empty()) WriteFileAtomically(FileOf(request.segments, name, several), SegmentsText(found));
  if (!request.picture.empty()) {
    const std::string picture = FileOf(request.picture, name, several);
    WritePicture(DrawVanishingPoints(photograph.gray, found.image.segments, found.estimate), picture);
    std::cout << "picture: " << picture << std::endl;
  }
  return found;
}

/// Nothing, and a line, for what is no image: the others of a list are looked at all the same.
std::optional<Photograph> Read(const std::string& path, const Request& request) {
  try {
    return ReadPhotograph(path, request.calibration);
  } catch (const Error& error) {
    if (request.images.size() == 1) throw;
    LogWarning(std::string("left out: ") + error.what());
    return std::nullopt;
  }
}

void CheckNames(const Request& request) {
  std::vector<std::string> names;
  for (const std::string& path : request.images) names.push_back(ImageName(path));
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice != names.end()) throw Error("two images are named " + *twice);
}

/// Before any work: what is written must not be what is read.
void CheckOutputs(const Request& request) {
  std::vector<std::string> inputs = request.calibration.Inputs(), outputs = {request.json, request.estimates};
  inputs.insert(inputs.end(), request.images.begin(), request.images.end());
  std::vector<std::string> pictures;
  for (const std::string& image : request.images) {
    const auto add = [&](const std::string& file, std::vector<std::string>* files) {
      if (!file.empty()) files->push_back(FileOf(file, ImageName(image), request.images.size() > 1));
    };
    add(request.picture, &pictures);
    add(request.segments, &outputs);
  }
  outputs.insert(outputs.end(), pictures.begin(), pictures.end());
  RefuseInputsAsOutputs(outputs, inputs);
  for (const std::string& picture : pictures) CheckPictureName(picture);
}

/// What was estimated of all images that could be read, in one file each.
void WriteAll(const Request& request, const std::vector<VanishingImage>& found) {
  if (!request.json.empty()) WriteFileAtomically(request.json, VanishingJson(found));
  if (request.estimates.empty()) return;
  std::vector<ImageSegments> images;
  std::vector<VanishingPointsEstimate> estimates;
  for (const VanishingImage& one : found) {
    images.push_back(one.image);
    estimates.push_back(one.estimate);
  }
  WriteSegments(request.estimates, images, estimates);
}

int Run(Request request) {
  InitLogging("", false);
  if (request.images.size() > 1) std::erase_if(request.images, PassOverOwnPicture);
  if (request.images.empty()) throw Error("expected an image");
  CheckNames(request);
  CheckOutputs(request);
  std::vector<VanishingImage> found;
  for (const std::string& path : request.images)
    if (const auto photograph = Read(path, request)) found.push_back(Treat(path, *photograph, request));
  if (!found.empty()) WriteAll(request, found);
  if (found.size() < request.images.size() && request.images.size() > 1)
    LogWarning(std::to_string(request.images.size() - found.size()) + " of " + std::to_string(request.images.size()) +
               " images were left out");
  if (found.empty()) return kExitBadInput;
  const bool all = std::all_of(found.begin(), found.end(), [](const VanishingImage& one) { return one.estimate.ok(); });
  return all ? kExitOk : kExitNoModel;
}

}  // namespace

int main(int argc, char** argv) {
  KeepFreedMemory();
  CLI::App app{"Vanishing points of photographs, with the camera's focal length and the horizon"};
  Request request;
  app.set_version_flag("--version", VersionText("diffsac_vanish"));
  app.footer(
      "Examples:\n"
      "  diffsac_vanish hall.jpg\n"
      "  diffsac_vanish street.png --focal 719 --center 607,185 --json street.json\n"
      "  diffsac_vanish photos/*.jpg --picture pictures/found.jpg --estimates found.h5\n"
      "Exit status: 0 every image that can be read has vanishing points, 1 one has none, 2 bad input, none can be "
      "read.\n"
      "More: docs/vanishing_points.md");
  AddOptions(&app, &request);
  return RunProgram("diffsac_vanish", &app, argc, argv, [&] { return Run(request); });
}
