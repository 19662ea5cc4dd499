#pragma once

#include <functional>
#include <optional>
#include <string>

namespace diffsac {

/// Where a process stands among those that a launcher (torchrun, srun, mpirun, mpiexec) started together.
struct ProcessPlace {
  int rank = 0;  ///< In [0, size).
  int size = 1;
  int local_rank = 0;                 ///< On its machine: which GPU is its own.
  int local_size = 1;                 ///< Processes on its machine; 1 where the launcher does not tell.
  std::string address = "127.0.0.1";  ///< Of the process of rank 0.
  int port = 29500;
  /// The launcher itself keeps the addresses of the processes (torchrun); else the process of rank 0 does.
  bool launcher_keeps_store = false;
  std::string store_prefix;  ///< Of the keys there.
};

/// The value of an environment variable.
using Environment = std::function<std::optional<std::string>(const std::string& name)>;

/// The variables of this process.
Environment ProcessEnvironment();

/// Reads what launchers set (docs/clusters.md). One process, or none of these variables: the default place. Throws
/// Error for values that are no numbers or out of range, and where the address of rank 0 cannot be known.
ProcessPlace FindProcessPlace(const Environment& environment = ProcessEnvironment());

/// The first name of a list as SLURM writes it: "gpu[03-05,9],login" is "gpu03".
std::string FirstHost(const std::string& nodes);

/// Threads for a process that was asked for no number: the cores that it may use, shared with its neighbours unless
/// the launcher has already bound it to a part of the machine.
int DefaultThreads(const ProcessPlace& place);

}  // namespace diffsac
