#include "lab/files/thumbnails.h"

#include <H5Cpp.h>

#include <filesystem>
#include <mutex>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/files/hdf5_input.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/files/hdf5_output.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

/// Opened, used and closed under the lock.
template <class Call>
auto Locked(Call call) {
  const std::lock_guard lock(Hdf5Mutex());
  H5::Exception::dontPrint();
  return call();
}

}  // namespace

void WriteThumbnails(const std::string& folder, const std::vector<std::string>& images,
                     const std::function<std::string(std::size_t)>& jpeg) {
  const std::string path = (fs::path(folder) / kThumbnailsFile).string();
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

std::string ReadThumbnail(const std::string& folder, const std::string& image) {
  const std::string path = (fs::path(folder) / kThumbnailsFile).string();
  std::error_code code;
  if (folder.empty() || image.empty() || !fs::exists(path, code)) return "";
  const std::string place = path + ": " + image;
  return Locked([&] {
    try {
      const H5::H5File file = OpenHdf5(path);
      if (!file.nameExists(image)) return std::string();
      const H5::DataSet data = file.openDataSet(image);
      if (data.getTypeClass() != H5T_INTEGER) throw Error(place + ": expected the bytes of a JPEG file");
      std::string bytes(CountOf(data, place), '\0');
      if (!bytes.empty()) data.read(bytes.data(), H5::PredType::NATIVE_UINT8);
      return bytes;
    } catch (const H5::Exception& e) {
      throw Error(place + ": damaged or truncated: " + Describe(e));
    }
  });
}

}  // namespace diffsac
