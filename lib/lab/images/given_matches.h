#pragma once

#include <map>
#include <string>
#include <vector>

#include "lab/files/correspondence_files.h"
#include "lab/images/image_source.h"
#include "lab/images/match_pair.h"
#include "lab/images/photographs.h"

namespace diffsac {

/// Pairs that came with their matches.
struct GivenPairs {
  CorrespondenceSet set;
  std::map<std::string, std::string> files = {};  ///< Of the images' names.
  std::size_t of_others = 0;                      ///< Pairs that were left out: of cameras that are not calibrated.
};

/// hloc's matches and features, as data_tools/hloc.py says: a file of matches, or a folder that holds both. Throws
/// Error.
GivenPairs ReadHlocPairs(const std::string& path);

/// The matches of a COLMAP database, or, where it has none, its verified ones: of pairs of cameras that are calibrated,
/// or of all, as they are seen. Throws Error.
GivenPairs ReadColmapPairs(const std::string& path, bool calibrated);

/// Problem::scale_rotation_changes of matches between keypoints whose frames (N × 2: logarithm of the size, angle in
/// radians) are given; empty where those of one image are.
PointMatrix ScaleRotationChangesOf(const PointMatrix& first, const PointMatrix& second, const MatchIndices& matches);

/// A scene's file holds all pairs: where a pair with matches has no similarities, none keeps them.
void KeepAllScaleRotationChangesOrNone(CorrespondenceSet* set);

/// Matches that something else made, in a NumPy file (convert.py, "matches", says of which) or a text file: x1 y1 x2 y2
/// of each, in pixels, the centre of the first one (0, 0); then what there is of ratio, log_size and angle (as
/// `diffsac_pair --matches` writes them). With a header columns are found by these names, in any order, and score, in
/// [0, 1] and higher for better, may stand for ratio. Equal matches stay.
struct GivenMatches {
  std::string file;              ///< Or, of many pairs, what AreManyMatches says.
  std::vector<ImageSize> sizes;  ///< Of the images; one stands for both, none: unknown.
};

/// The same of such a file, in no time. Throws Error: a file that cannot be read, a line of it, a calibration that is
/// none or that needs the images' sizes.
ImagePair ReadMatches(const GivenMatches& given, const GivenCalibration& calibration);

/// Points of a known scene in an image, x y X Y Z, likewise, with the ratio where there is one (and no similarities).
/// The task is absolute_pose.
ImagePair ReadScenePoints(const GivenMatches& given, const GivenCalibration& calibration);

/// Whether a path holds many pairs: a folder, of files as above or with hloc's two; hloc's matches (.h5, the features
/// beside them); a COLMAP database (.db).
bool AreManyMatches(const std::string& path);

/// Reads them: the pairs of a folder, a file each, are called as the file; of "A-B" the images are A and B. A file that
/// cannot be read is named and left out. hloc's and COLMAP's images find their cameras by their names. Without a
/// calibration, and for `poses` of calibrated cameras, those of the database are taken, and its other pairs left out.
/// What only some pairs have, all go without: ratios, scores, sizes. Throws Error.
GivenPairs ReadManyMatches(const GivenMatches& given, const GivenCalibration& calibration, bool poses);

/// Such pairs as photographs without paths.
struct GivenPhotographs {
  Photographs photographs;
  std::vector<ImageSize> sizes;  ///< By image.
  std::vector<ImagePair> pairs;  ///< Those of the scene.
};

/// A pair whose images have no names has two of its own.
GivenPhotographs PhotographsOf(GivenPairs given, const std::string& scene);

}  // namespace diffsac
