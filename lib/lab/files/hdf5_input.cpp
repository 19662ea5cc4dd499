#include "lab/files/hdf5_input.h"

namespace diffsac {

H5::H5File OpenHdf5(const std::string& path) { return H5::H5File(path, H5F_ACC_RDONLY); }

H5::H5File OpenHdf5Bytes(const std::string& bytes) {
  constexpr std::size_t kIncrement = 1 << 20;
  H5::FileAccPropList access;
  access.setCore(kIncrement, false);
  H5Pset_file_image(access.getId(), const_cast<char*>(bytes.data()), bytes.size());
  return H5::H5File("in memory", H5F_ACC_RDONLY, H5::FileCreatPropList::DEFAULT, access);
}

}  // namespace diffsac
