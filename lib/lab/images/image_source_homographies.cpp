#include <algorithm>
#include <filesystem>

#include "diffsac/core/status.h"
#include "lab/files/text_scan.h"
#include "lab/images/image_source.h"
#include "lab/images/run_pairs.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// How a set names its files.
struct Naming {
  std::string image, matrix_prefix, matrix_suffix;
  std::string Matrix(int n) const { return matrix_prefix + std::to_string(n) + matrix_suffix; }
  std::string Image(int n) const { return image + std::to_string(n); }
};

std::string PathOf(const std::vector<std::string>& images, const std::string& stem, const std::string& folder) {
  const auto found =
      std::find_if(images.begin(), images.end(), [&](const auto& path) { return fs::path(path).stem() == stem; });
  if (found == images.end()) throw Error(folder + ": no image " + stem);
  return *found;
}

}  // namespace

ImageSource ReadHomographies(const std::string& folder) {
  const std::vector<std::string> images = ListImages(folder);
  for (const Naming& naming : {Naming{"img", "H1to", "p"}, Naming{"", "H_1_", ""}}) {
    ImageSource source;
    SourceScene scene{FolderName(folder), {}};
    for (int n = 2; fs::exists(fs::path(folder) / naming.Matrix(n)); ++n) {
      if (n == 2) source.images.push_back({naming.Image(1), PathOf(images, naming.Image(1), folder), {}, {}});
      Eigen::Matrix3d H;
      const auto read = [&] {
        H = ReadMatrixFile((fs::path(folder) / naming.Matrix(n)).string());
        if (!H.allFinite() || H.isZero(0.0)) throw Error(folder + "/" + naming.Matrix(n) + ": expected a homography");
        return SourceImage{naming.Image(n), PathOf(images, naming.Image(n), folder), {}, {}};
      };
      const std::size_t before = source.images.size();
      AddImage(naming.Image(n), read, &source);
      if (source.images.size() > before) scene.pairs.push_back({0, static_cast<int>(before), H});
    }
    if (source.images.empty()) continue;
    source.scenes.push_back(std::move(scene));
    CheckSource(source, folder);
    return source;
  }
  throw Error(folder + ": no homographies H1to2p ... or H_1_2 ...");
}

namespace {

const Registered<ImageFormat> kHomographies("homographies", {.read = [](const PairsRequest& request) {
                                              return ReadHomographies(request.input);
                                            }});

}  // namespace

}  // namespace diffsac
