#pragma once

#include <string>

namespace diffsac {

class OptionsBinder;
enum class Task : int;
struct ClassicalOptions;
struct ConsensusOptions;
struct DenoiserOptions;
struct DiffsacOptions;
struct LearnedOptions;
struct MinimalSamplerOptions;
struct NetworkOptions;
struct NoiseScheduleOptions;
struct PointFeaturesOptions;
struct ReverseSamplerOptions;
struct SetScorerOptions;
struct InstanceSearchOptions;

// Keys, limits and documentation of the library's structs, which know no configuration.

// bind_consensus.cpp
void BindOptions(OptionsBinder& b, ConsensusOptions& options);
void BindOptions(OptionsBinder& b, MinimalSamplerOptions& options);
void BindOptions(OptionsBinder& b, InstanceSearchOptions& options);

// bind_network.cpp
void BindOptions(OptionsBinder& b, PointFeaturesOptions& options);
void BindOptions(OptionsBinder& b, NoiseScheduleOptions& options);
void BindOptions(OptionsBinder& b, ReverseSamplerOptions& options);
void BindOptions(OptionsBinder& b, DenoiserOptions& options);
void BindOptions(OptionsBinder& b, NetworkOptions& options);
void BindOptions(OptionsBinder& b, SetScorerOptions& options);

// bind_estimators.cpp
void BindOptions(OptionsBinder& b, ClassicalOptions& options);
void BindOptions(OptionsBinder& b, DiffsacOptions& options);
/// The keys of all learned rows but weighted_fit, whose key is the method's.
void BindShared(OptionsBinder& b, LearnedOptions& options);
/// The key `model`: the name of one of a task's models, "" for its own.
void BindModel(OptionsBinder& b, Task task, std::string* model);

}  // namespace diffsac
