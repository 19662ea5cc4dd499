#include "lab/files/thumbnails.h"

#include <filesystem>

#include "lab/files/hdf5_output.h"

namespace diffsac {

void WriteThumbnails(const std::string& folder, const std::vector<std::string>& images,
                     const std::function<std::string(std::size_t)>& jpeg) {
  const std::string path = (std::filesystem::path(folder) / kThumbnailsFile).string();
  WriteHdf5(path, [&](Hdf5Output& file) {
    for (std::size_t i = 0; i < images.size(); ++i) {
      const std::string bytes = jpeg(i);
      if (!bytes.empty()) file.Put(images[i], bytes.data(), {bytes.size()});
    }
  });
}

}  // namespace diffsac
