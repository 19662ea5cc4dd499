#include <filesystem>
#include <string_view>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/files/text_scan.h"
#include "lab/images/image_format.h"
#include "lab/images/number_file.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// The first file whose name ends with _par.txt.
std::string ParameterFile(const std::string& folder) {
  std::error_code code;
  std::string found;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    const std::string path = entry.path().string();
    if (path.ends_with("_par.txt") && (found.empty() || path < found)) found = path;
  }
  if (found.empty()) throw Error(folder + ": no file NAME_par.txt");
  return found;
}

// IMAGE K (9) R (9) t (3), world-to-camera.
SourceImage ReadImage(const std::string& folder, const std::vector<std::string_view>& words, const std::string& place) {
  if (words.size() < 22) throw Error(place + ": expected an image and 21 numbers");
  // A name may have blanks.
  const std::string_view* numbers = words.data() + words.size() - 21;
  const std::string_view last = numbers[-1];
  const std::string name(words[0].data(), static_cast<std::size_t>(last.data() + last.size() - words[0].data()));
  const std::string path = (fs::path(folder) / name).string();
  if (!fs::exists(path)) throw Error(place + ": there is no " + path);
  double v[21];
  for (int i = 0; i < 21; ++i)
    if (!ParseNumber(numbers[i], v + i)) throw Error(place + ": '" + std::string(numbers[i]) + "' is no number");
  SourceImage image{ImageName(path), path, {}, {}};
  LensCamera camera;
  camera.K = MatrixFromRows(v);
  if (!camera.K.allFinite() || !(camera.K(0, 0) > 0.0) || !(camera.K(1, 1) > 0.0))
    throw Error(place + ": expected a calibration matrix");
  image.camera = camera;
  image.pose = SoundMotion({MatrixFromRows(v + 9), {v[18], v[19], v[20]}}, place);
  return image;
}

ImageSource ReadMiddlebury(const PairsRequest& request) {
  const std::string file = ParameterFile(request.input), text = ReadTextFile(file);
  ImageSource source;
  std::string_view rest = text, line;
  for (int number = 1; TakeLine(&rest, &line); ++number) {
    const auto words = SplitWords(line, " \t");
    // The first line has the number of images.
    if (words.size() < 2) continue;
    AddImage(
        ImageName(std::string(words[0])),
        [&] { return ReadImage(request.input, words, file + ":" + std::to_string(number)); }, &source);
  }
  AddAllPairs(request.input, &source);
  return source;
}

const Registered<ImageFormat> kMiddlebury("middlebury", {.read = ReadMiddlebury});

}  // namespace
}  // namespace diffsac
