#pragma once

#include <string>

#include "lab/train/trainer.h"

namespace diffsac {

/// Writes request.output/checkpoints/best.safetensors and config.yaml with weights that another program trained in
/// place of a training: a checkpoint as any other, for rows and for train.start_from. `file` is as scripts/peers/ write
/// it: safetensors, `network.NAME` for each parameter, `method` and `task` in its metadata. Nothing is read of the
/// configuration's data. Throws Error where the folder is used (CheckStart), and naming the file where it is for
/// another method or task, or a tensor's name or shape differs from those of the configuration's network.
void ImportNetwork(const TrainRequest& request, const std::string& file);

}  // namespace diffsac
