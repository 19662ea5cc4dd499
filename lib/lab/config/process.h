#pragma once

namespace diffsac {

/// Lets the process keep memory that it frees, where the C library is glibc: it otherwise returns every large tensor to
/// the system and has the next one's pages zeroed again, which takes a third of a training's time on a CPU, and more
/// where several processes train. For programs; before threads are started. A process's memory then stays at its peak.
void KeepFreedMemory();

/// The most memory that the process has had at once, in MiB.
double PeakMemoryMib();

/// Lets OpenMP's threads, LibTorch's, sleep while they wait for each other instead of spinning: where cores are shared
/// spinning made a small network up to fifty times slower. OpenMP reads OMP_WAIT_POLICY when it is loaded, so unless it
/// is set already the program starts itself once more with it: call this first in main, with its arguments. Returns
/// where nothing is to be done or can be.
void WaitPassively(char** argv);

}  // namespace diffsac
