#include "lab/torch/process_place.h"

#include <catch2/catch.hpp>

#include <map>

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

using Catch::Contains;

ProcessPlace Find(std::map<std::string, std::string> variables) {
  return FindProcessPlace([variables](const std::string& name) -> std::optional<std::string> {
    const auto found = variables.find(name);
    return found == variables.end() ? std::nullopt : std::optional<std::string>(found->second);
  });
}

}  // namespace

TEST_CASE("a process that no launcher started is alone") {
  CHECK(Find({}).size == 1);
  CHECK(Find({{"RANK", "3"}}).size == 1);
  CHECK(Find({{"RANK", "0"}, {"WORLD_SIZE", "1"}}).size == 1);
  // SLURM's batch script: only what srun starts is a step.
  CHECK(Find({{"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "8"}, {"SLURM_NODELIST", "a[1-8]"}}).size == 1);
}

TEST_CASE("torchrun's variables are read") {
  const auto place = Find({{"RANK", "5"},
                           {"WORLD_SIZE", "8"},
                           {"LOCAL_RANK", "1"},
                           {"LOCAL_WORLD_SIZE", "4"},
                           {"MASTER_ADDR", "node7"},
                           {"MASTER_PORT", "4321"}});
  CHECK(place.rank == 5);
  CHECK(place.size == 8);
  CHECK(place.local_rank == 1);
  CHECK(place.local_size == 4);
  CHECK(place.address == "node7");
  CHECK(place.port == 4321);
  CHECK_FALSE(place.launcher_keeps_store);
  const auto agent = Find({{"RANK", "1"},
                           {"WORLD_SIZE", "2"},
                           {"MASTER_ADDR", "a"},
                           {"MASTER_PORT", "1"},
                           {"TORCHELASTIC_USE_AGENT_STORE", "True"},
                           {"TORCHELASTIC_RESTART_COUNT", "2"}});
  CHECK(agent.launcher_keeps_store);
  CHECK(agent.store_prefix == "/worker/attempt_2");
}

TEST_CASE("Open MPI's and MPICH's variables are read") {
  const auto open_mpi = Find({{"OMPI_COMM_WORLD_RANK", "2"},
                              {"OMPI_COMM_WORLD_SIZE", "4"},
                              {"OMPI_COMM_WORLD_LOCAL_RANK", "2"},
                              {"OMPI_COMM_WORLD_LOCAL_SIZE", "4"},
                              // Its daemons are a step of SLURM's with one task.
                              {"SLURM_PROCID", "0"},
                              {"SLURM_NTASKS", "1"},
                              {"SLURM_STEP_ID", "0"}});
  CHECK(open_mpi.rank == 2);
  CHECK(open_mpi.size == 4);
  CHECK(open_mpi.address == "127.0.0.1");  // All on one machine.
  CHECK(open_mpi.port == 29500);
  const auto mpich = Find({{"PMI_RANK", "1"}, {"PMI_SIZE", "2"}, {"MASTER_ADDR", "there"}});
  CHECK(mpich.rank == 1);
  CHECK(mpich.local_rank == 0);
  CHECK(mpich.address == "there");
}

TEST_CASE("srun's variables are read") {
  const std::map<std::string, std::string> step = {{"SLURM_PROCID", "3"},         {"SLURM_NTASKS", "4"},
                                                   {"SLURM_LOCALID", "1"},        {"SLURM_STEP_ID", "0"},
                                                   {"SLURM_JOB_ID", "1234567"},   {"SLURM_STEP_NODELIST", "gpu[03-04]"},
                                                   {"SLURM_NTASKS_PER_NODE", "2"}};
  const auto place = Find(step);
  CHECK(place.rank == 3);
  CHECK(place.size == 4);
  CHECK(place.local_rank == 1);
  CHECK(place.local_size == 2);
  CHECK(place.address == "gpu03");
  CHECK(place.port == 15000 + 1234567 % 15000);
  auto full = step;  // Four tasks may still be on two machines.
  full["SLURM_NTASKS_PER_NODE"] = "4";
  CHECK(Find(full).address == "gpu03");
  auto named = step;
  named["MASTER_ADDR"] = "head";
  named["MASTER_PORT"] = "777";
  named["SLURM_STEP_NUM_TASKS"] = "6";
  CHECK(Find(named).address == "head");
  CHECK(Find(named).port == 777);
  CHECK(Find(named).size == 6);
}

TEST_CASE("the first host of a list") {
  CHECK(FirstHost("one") == "one");
  CHECK(FirstHost("one,two") == "one");
  CHECK(FirstHost("gpu[03-05,9],login") == "gpu03");
  CHECK(FirstHost("gpu[7,9]") == "gpu7");
  CHECK(FirstHost("rack1-n[12]-ib,x") == "rack1-n12-ib");
}

TEST_CASE("variables that make no sense are one clear line") {
  CHECK_THROWS_WITH(Find({{"RANK", "2"}, {"WORLD_SIZE", "2"}}), Contains("RANK='2'") && Contains("from 0 to 1"));
  CHECK_THROWS_WITH(Find({{"RANK", "x"}, {"WORLD_SIZE", "2"}}), Contains("RANK='x'"));
  CHECK_THROWS_WITH(Find({{"RANK", "0"}, {"WORLD_SIZE", "0"}}), Contains("WORLD_SIZE='0'"));
  CHECK_THROWS_WITH(Find({{"RANK", "0"}, {"WORLD_SIZE", "2"}, {"MASTER_ADDR", "a"}, {"MASTER_PORT", "70000"}}),
                    Contains("MASTER_PORT='70000'"));
  CHECK_THROWS_WITH(Find({{"PMI_RANK", "1"}, {"PMI_SIZE", "2"}}), Contains("set MASTER_ADDR"));
}

TEST_CASE("processes of one machine share its cores") {
  ProcessPlace place;
  CHECK(DefaultThreads(place) == HardwareThreads());
  place.local_size = 1000;
  CHECK(DefaultThreads(place) >= 1);
  CHECK(DefaultThreads(place) <= HardwareThreads());
}

}  // namespace diffsac
