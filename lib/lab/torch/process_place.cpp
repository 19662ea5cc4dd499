#include "lab/torch/process_place.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

// The variables that one launcher sets.
struct Names {
  const char* rank;
  const char* size;
  const char* local_rank;
  const char* local_size;
  bool local_size_is_exact = true;  // SLURM's is the most that a machine may have.
};

constexpr Names kLaunchers[] = {
    {"RANK", "WORLD_SIZE", "LOCAL_RANK", "LOCAL_WORLD_SIZE"},
    {"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_LOCAL_RANK", "OMPI_COMM_WORLD_LOCAL_SIZE"},
    {"PMI_RANK", "PMI_SIZE", "MPI_LOCALRANKID", "MPI_LOCALNRANKS"},
};
// Last: mpirun starts its daemons with srun, so that SLURM's variables are those of the daemons.
constexpr Names kSlurmStep = {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS", "SLURM_LOCALID", "SLURM_NTASKS_PER_NODE", false};
constexpr Names kSlurm = {"SLURM_PROCID", "SLURM_NTASKS", "SLURM_LOCALID", "SLURM_NTASKS_PER_NODE", false};

int Number(const Environment& environment, const std::string& name, int otherwise, int low, int high) {
  const auto text = environment(name);
  if (!text || text->empty()) return otherwise;
  int value = 0;
  const char* end = text->data() + text->size();
  const auto result = std::from_chars(text->data(), end, value);
  if (result.ec != std::errc() || result.ptr != end || value < low || value > high)
    throw Error("environment: " + name + "='" + *text + "', expected a number from " + std::to_string(low) + " to " +
                std::to_string(high));
  return value;
}

std::optional<Names> FindLauncher(const Environment& environment) {
  for (const Names& names : kLaunchers)
    if (environment(names.rank) && environment(names.size)) return names;
  // A batch script has SLURM_PROCID as well, but is one process: only srun's steps have a number.
  if (!environment("SLURM_STEP_ID") || !environment("SLURM_PROCID")) return std::nullopt;
  if (environment(kSlurmStep.size)) return kSlurmStep;
  if (environment(kSlurm.size)) return kSlurm;
  return std::nullopt;
}

std::string Address(const Environment& environment, const ProcessPlace& place, bool local_size_is_exact) {
  if (const auto address = environment("MASTER_ADDR"); address && !address->empty()) return *address;
  if (local_size_is_exact && place.local_size == place.size) return place.address;
  for (const char* name : {"SLURM_STEP_NODELIST", "SLURM_JOB_NODELIST", "SLURM_NODELIST"})
    if (const auto nodes = environment(name); nodes && !nodes->empty()) return FirstHost(*nodes);
  throw Error("environment: process " + std::to_string(place.rank) + " of " + std::to_string(place.size) +
              " does not know the machine of process 0; set MASTER_ADDR for all (mpirun -x MASTER_ADDR=host)");
}

int Port(const Environment& environment, int otherwise) {
  constexpr int kFirst = 15000, kPorts = 15000;  // Below those that systems give to outgoing connections.
  const int job = Number(environment, "SLURM_JOB_ID", 0, 0, 2147483647);
  return Number(environment, "MASTER_PORT", job > 0 ? kFirst + job % kPorts : otherwise, 1, 65535);
}

}  // namespace

Environment ProcessEnvironment() {
  return [](const std::string& name) -> std::optional<std::string> {
    const char* value = std::getenv(name.c_str());
    return value == nullptr ? std::nullopt : std::optional<std::string>(value);
  };
}

ProcessPlace FindProcessPlace(const Environment& environment) {
  constexpr int kMost = 1 << 20;
  ProcessPlace place;
  const auto names = FindLauncher(environment);
  if (!names) return place;
  place.size = Number(environment, names->size, 1, 1, kMost);
  if (place.size == 1) return {};
  place.rank = Number(environment, names->rank, 0, 0, place.size - 1);
  place.local_rank = Number(environment, names->local_rank, 0, 0, kMost);
  place.local_size = Number(environment, names->local_size, 1, 1, kMost);
  place.address = Address(environment, place, names->local_size_is_exact);
  place.port = Port(environment, place.port);
  place.launcher_keeps_store = environment("TORCHELASTIC_USE_AGENT_STORE").value_or("") == "True";
  if (place.launcher_keeps_store)
    place.store_prefix = "/worker/attempt_" + environment("TORCHELASTIC_RESTART_COUNT").value_or("0");
  return place;
}

std::string FirstHost(const std::string& nodes) {
  const std::string first = nodes.substr(0, nodes.find_first_of("[,"));
  if (first.size() == nodes.size() || nodes[first.size()] == ',') return first;
  const std::size_t numbers = first.size() + 1, close = nodes.find(']', numbers);
  const std::string number = nodes.substr(numbers, nodes.find_first_of("-,]", numbers) - numbers);
  if (close == std::string::npos) return first + number;
  const std::string suffix = nodes.substr(close + 1, nodes.find(',', close) - close - 1);
  return first + number + suffix;
}

int DefaultThreads(const ProcessPlace& place) {
  const int usable = HardwareThreads();
  const bool bound = usable < static_cast<int>(::sysconf(_SC_NPROCESSORS_ONLN));
  return bound ? usable : std::max(1, usable / place.local_size);
}

}  // namespace diffsac
