#pragma once

#include <H5Cpp.h>

namespace diffsac {

/// Asks the library for all that our readers could ask for: names, kinds, attributes and values of at most `budget`
/// bytes, from opening to closing. What fails is passed over. It calls only C functions of the library and allocates
/// nothing by itself but buffers, so that a child of a process with several threads may call it.
void WalkHdf5(const char* path, hid_t access, hsize_t budget);

}  // namespace diffsac
