#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "data_tools/image_source.h"
#include "diffsac/io/segment_files.h"

namespace diffsac {

/// The command `diffsac_prepare segments`: line segments of images as SCENE/segments.h5 (io/segment_files.h).
///   images    photographs in a folder, or one photograph: segments by OpenCV's detector (von Gioi et al., "LSD", PAMI
///             2010), K from --calibration, --focal or EXIF
///   nyu_vp    the folder `data` of NYU-VP (Kluger et al., CVPR 2020): scenes nyu_vp_train, _val and _test
///   yud_plus  the folder `data` of YUD+ (the same): scenes yud_plus_train and _test
struct SegmentsRequest {
  std::string format = "images", input, output;
  std::string scene;             ///< images: the scene's name; empty: the folder's.
  GivenCalibration calibration;  ///< images: of all of them; not given: EXIF's focal length, if there is one.
  int max_image_size = 0;        ///< images: larger ones are reduced to this longer side; 0: never.
  bool overwrite = false;
  int threads = 0;
};

/// Benchmarks whose segments come with them.
inline constexpr const char* kSegmentBenchmarks[] = {"nyu_vp", "yud_plus"};
bool IsSegmentBenchmark(const std::string& format);

/// The segments that the detector finds, in pixels of the file, longest first. Throws Error naming the file.
ImageSegments DetectSegments(const std::string& path, int max_image_size);

/// Prints a line a scene. False when it was stopped. Throws Error.
bool PrepareSegments(const SegmentsRequest& request, const std::atomic<bool>& stop);

}  // namespace diffsac
