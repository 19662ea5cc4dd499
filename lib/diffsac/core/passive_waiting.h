#pragma once

namespace diffsac {

/// Lets OpenMP's threads, LibTorch's, sleep while they wait for each other instead of spinning: where cores are shared
/// spinning made a small network up to fifty times slower. OpenMP reads OMP_WAIT_POLICY when it is loaded, so unless it
/// is set already the program starts itself once more with it: call this first in main, with its arguments. Returns
/// where nothing is to be done or can be.
void WaitPassively(char** argv);

}  // namespace diffsac
