#include "lab/eval/linear_assignment.h"

#include <limits>

namespace diffsac {
namespace {

constexpr int kFree = -1;

// Rows and columns have potentials; a pair's reduced cost, cost − potential − potential, is never negative, and zero
// for what is assigned.
class Augmenter {
 public:
  explicit Augmenter(const Eigen::MatrixXd& costs)
      : costs_(costs),
        of_rows_(Eigen::VectorXd::Zero(costs.rows())),
        of_columns_(Eigen::VectorXd::Zero(costs.cols())),
        row_of_(static_cast<std::size_t>(costs.cols()), kFree) {}

  // Assigns one more row, along the cheapest alternating path from it to a free column.
  void Add(int row) {
    Eigen::VectorXd cheapest = Eigen::VectorXd::Constant(costs_.cols(), std::numeric_limits<double>::infinity());
    std::vector<int> from(row_of_.size(), kFree);  // The column before on the path; kFree: the new row.
    std::vector<char> reached(row_of_.size(), 0);
    int column = kFree;
    for (int at = row; at != kFree; at = row_of_[column]) {
      const int next = Reach(at, column, reached, &cheapest, &from);
      Raise(cheapest[next], row, reached, &cheapest);
      column = next;
      reached[column] = 1;
    }
    for (; column != kFree; column = from[column])
      row_of_[column] = from[column] == kFree ? row : row_of_[from[column]];
  }

  const std::vector<int>& row_of() const { return row_of_; }

 private:
  // The nearest column that is not reached yet, once the ways by row `at` are known.
  int Reach(int at, int column, const std::vector<char>& reached, Eigen::VectorXd* cheapest, std::vector<int>* from) {
    int nearest = kFree;
    for (int c = 0; c < costs_.cols(); ++c) {
      if (reached[c] != 0) continue;
      const double reduced = costs_(at, c) - of_rows_[at] - of_columns_[c];
      if (reduced < (*cheapest)[c]) {
        (*cheapest)[c] = reduced;
        (*from)[c] = column;
      }
      if (nearest == kFree || (*cheapest)[c] < (*cheapest)[nearest]) nearest = c;
    }
    return nearest;
  }

  // Makes the nearest column's reduced cost zero, and keeps those of the tree.
  void Raise(double step, int row, const std::vector<char>& reached, Eigen::VectorXd* cheapest) {
    of_rows_[row] += step;
    for (int c = 0; c < costs_.cols(); ++c) {
      if (reached[c] != 0) {
        of_rows_[row_of_[c]] += step;
        of_columns_[c] -= step;
      } else {
        (*cheapest)[c] -= step;
      }
    }
  }

  const Eigen::MatrixXd& costs_;
  Eigen::VectorXd of_rows_, of_columns_;
  std::vector<int> row_of_;
};

}  // namespace

std::vector<int> BestAssignment(const Eigen::MatrixXd& gains) {
  const bool wide = gains.rows() <= gains.cols();
  const Eigen::MatrixXd costs = wide ? Eigen::MatrixXd(-gains) : Eigen::MatrixXd(-gains.transpose());
  Augmenter augmenter(costs);
  for (int row = 0; row < costs.rows(); ++row) augmenter.Add(row);
  if (!wide) return augmenter.row_of();
  std::vector<int> columns(static_cast<std::size_t>(gains.rows()), kFree);
  for (std::size_t c = 0; c < augmenter.row_of().size(); ++c)
    if (augmenter.row_of()[c] != kFree) columns[augmenter.row_of()[c]] = static_cast<int>(c);
  return columns;
}

}  // namespace diffsac
