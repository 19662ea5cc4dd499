#pragma once

#include <string>
#include <vector>

#include "lab/registration/register_scans.h"

namespace diffsac {

/// What is found of two scans, for a terminal: R, t, deviations, overlap; or why there is none.
std::string RegistrationText(const Scan& first, const Scan& second, const Registration& registration);

/// The same as one JSON object.
std::string RegistrationJson(const Scan& first, const Scan& second, const Registration& registration);

/// One pair of a folder's scans.
struct ScanPair {
  int first = 0, second = 0;  ///< Places in the list of scans.
  Registration registration;
};

/// Whether it is an edge of a pose graph: found, not by chance, of surfaces that hold, with a covariance and so without
/// a rival.
bool IsEdge(const Registration& registration);

/// registrations.csv: a line a pair, all pairs.
std::string RegistrationsCsv(const std::vector<Scan>& scans, const std::vector<ScanPair>& pairs);

/// A pose graph as g2o reads it (https://github.com/RainerKuemmerle/g2o/wiki/File-Format): VERTEX_SE3:QUAT for each
/// scan, its pose by the edges of most inliers from the first scan of its group, which is at the origin and has a FIX;
/// EDGE_SE3:QUAT with information matrices for each pair that IsEdge. Comments name the files.
std::string PoseGraphText(const std::vector<Scan>& scans, const std::vector<ScanPair>& pairs);

}  // namespace diffsac
