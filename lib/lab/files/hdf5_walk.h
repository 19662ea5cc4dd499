#pragma once

#include <H5Cpp.h>

namespace diffsac {

/// Asks the library for all that our readers could ask for: names, kinds, attributes and values of at most `budget`
/// bytes, from opening to closing. What fails is passed over. False when memory was refused: what the library does with
/// more of it is not known then. Prints no errors. It calls only C functions of the library and allocates
/// nothing by itself but buffers, so that a child of a process with several threads may call it.
bool WalkHdf5(const char* path, hid_t access, hsize_t budget);

}  // namespace diffsac
