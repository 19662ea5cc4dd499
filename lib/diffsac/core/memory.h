#pragma once

namespace diffsac {

/// Lets the process keep memory that it frees, where the C library is glibc: it otherwise returns every large tensor to
/// the system and has the next one's pages zeroed again, which takes a third of a training's time on a CPU, and more
/// where several processes train. For programs; before threads are started. A process's memory then stays at its peak.
void KeepFreedMemory();

/// The most memory that the process has had at once, in MiB.
double PeakMemoryMib();

}  // namespace diffsac
