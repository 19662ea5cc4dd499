#include "lab/files/thumbnails.h"

#include <H5Cpp.h>

#include <filesystem>

#include "lab/files/files.h"
#include "lab/files/hdf5_output.h"

namespace diffsac {

void WriteThumbnails(const std::string& folder, const std::vector<std::string>& images,
                     const std::function<std::string(std::size_t)>& jpeg) {
  const std::string path = (std::filesystem::path(folder) / kThumbnailsFile).string();
  WriteFileAtomically(path, [&](const std::string& temporary) {
    Hdf5Output file(temporary, path);
    for (std::size_t i = 0; i < images.size(); ++i) {
      const std::string bytes = jpeg(i);
      if (!bytes.empty())
        file.Put(images[i], H5::PredType::STD_U8LE, H5::PredType::NATIVE_UINT8, bytes.data(), {bytes.size()});
    }
    file.Close();
  });
}

}  // namespace diffsac
