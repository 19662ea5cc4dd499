#pragma once

#include <string>

#include "diffsac/train/trainer.h"

namespace diffsac {

/// Writes request.output/checkpoints/best.pt and config.yaml with weights that another program trained
/// (data/weight_file.h) in place of a training: a checkpoint as any other, for rows and for train.start_from. Nothing
/// is read of the configuration's data. Throws Error naming the file where it is for another method or task, or a
/// weight's name or shape differs from those of the configuration's network.
void ImportNetwork(const TrainRequest& request, const std::string& file);

}  // namespace diffsac
