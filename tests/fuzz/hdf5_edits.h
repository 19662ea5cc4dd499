#pragma once

#include <string>
#include <vector>

#include "fuzz/byte_reader.h"

namespace diffsac::testing {

/// Changes a sound HDF5 file as bytes say, by the library's own means: up to six of its objects and attributes, or new
/// ones, are removed or replaced by others of any kind, type, shape and layout, among them values that claim any number
/// and were never written, values in other files, links to nowhere and to themselves, and texts.
///
/// The files stay such as the library itself would write.
void EditHdf5(const std::string& path, ByteReader* reader);

/// Seeds for a target whose first byte chooses one of `choices`: each unchanged, and with some changes.
std::vector<std::string> EditSeeds(int choices);

}  // namespace diffsac::testing
