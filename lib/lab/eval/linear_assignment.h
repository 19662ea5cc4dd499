#pragma once

#include <Eigen/Core>
#include <vector>

namespace diffsac {

/// The assignment problem: for each row a column of its own, or −1, so that the sum of the gains is the largest. Every
/// row has a column where there are as many columns as rows; gains are finite. (The Hungarian method: Kuhn, Naval
/// Research Logistics Quarterly 1955, in the form of shortest augmenting paths, O(rows² columns).)
std::vector<int> BestAssignment(const Eigen::MatrixXd& gains);

}  // namespace diffsac
