#pragma once

#include <string>
#include <vector>

namespace diffsac {

/// What a network finds in an image: `places` x and y, `scores`, `descriptors`, one keypoint after the other.
struct NetworkKeypoints {
  std::vector<float> places, scores, descriptors;
};

/// A module of TorchScript (XFeat: Potje et al., "XFeat: Accelerated Features for Lightweight Image Matching", CVPR
/// 2024; scripts/peers/export_xfeat.py) on one thread of the CPU: the strongest `most` keypoints of width × height grey
/// values. `model` is its file, read once. Returns what is wrong, or nothing. Thread-safe.
using FindNetworkKeypoints = std::string (*)(const std::string& model, const unsigned char* grey, int width, int height,
                                             int most, NetworkKeypoints* found);

/// The function of lib/diffsac/diffsac_keypoints.so beside the running program (lab/torch/keypoint_module.cpp).
/// LibTorch is loaded with it, when it is first asked for: programs start without, and run where there is none. Throws
/// Error then.
FindNetworkKeypoints NetworkKeypointsFunction();

}  // namespace diffsac
