#pragma once

#include <string>
#include <vector>

namespace diffsac {

/// Lets the process keep memory that it frees, where the C library is glibc: it otherwise returns every large tensor to
/// the system and has the next one's pages zeroed again, which takes a third of a training's time on a CPU, and more
/// where several processes train. For programs; before threads are started. A process's memory then stays at its peak.
void KeepFreedMemory();

/// The most memory that the process has had at once, in MiB.
double PeakMemoryMib();

/// What the machine, or the process's control group where that has less, can give without swapping, and what the
/// process has freed and kept, in MiB; infinite where the system does not tell.
double AvailableMemoryMib();

/// Lets OpenMP's threads, LibTorch's, sleep while they wait for each other instead of spinning: where cores are shared
/// spinning made a small network up to fifty times slower. OpenMP reads OMP_WAIT_POLICY when it is loaded, so unless it
/// is set already the program starts itself once more with it: call this first in main, with its arguments. Returns
/// where nothing is to be done or can be.
void WaitPassively(char** argv);

/// Starts another program (its name or path, then its arguments; no shell, so that none needs quoting) that reads
/// nothing and says all into `output`, and that gets the signal `death` when this process ends, however that ends. Its
/// id; below 0 where it cannot be started.
int StartProgram(const std::vector<std::string>& words, int output, int death);

/// What it ended with, once it has; kCannotRun where that is not known or a signal ended it.
inline constexpr int kCannotRun = 127;
int EndOfProgram(int process);

/// How the programs end (docs/reliability.md): done; photographs without a model; bad input, data or files, which one
/// line on stderr names; stopped by Ctrl-C or SIGTERM.
inline constexpr int kExitOk = 0;
inline constexpr int kExitNoModel = 1;
inline constexpr int kExitBadInput = 2;
inline constexpr int kExitInterrupted = 130;

/// The same, for --help, and where its documentation is.
inline constexpr const char* kExitCodesHelp =
    "In an installation these pages are in share/doc/diffsac, configurations in share/diffsac/configs.\n"
    "Exit status: 0 done; 2 bad input, data or files, named in one line on stderr; 130 stopped by Ctrl-C or SIGTERM.";

}  // namespace diffsac
