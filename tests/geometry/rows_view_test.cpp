#include "diffsac/geometry/rows_view.h"

#include <catch2/catch.hpp>
#include <vector>

namespace diffsac {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

RowMajor Some() {
  RowMajor points(3, 2);
  points << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
  return points;
}

/// Whether the view reads this number itself.
bool Sees(const Points2DView& view, const double& number) { return &view.matrix().coeffRef(0, 0) == &number; }

TEST_CASE("views read matrices blocks and maps in place") {
  const RowMajor rows = Some();
  const Eigen::Matrix<double, Eigen::Dynamic, 2> columns = rows;
  Eigen::MatrixXd wide(3, 4);
  wide << rows, rows;
  const Eigen::Map<const RowMajor, 0, Eigen::OuterStride<>> every_second(rows.data(), 2, 2, Eigen::OuterStride<>(4));
  CHECK(Sees(rows, rows(0, 0)));
  CHECK(Sees(columns, columns(0, 0)));
  CHECK(Sees(wide.rightCols(2), wide(0, 2)));
  CHECK(Sees(wide.transpose().topRows(2).transpose(), wide(0, 0)));
  CHECK(Sees(every_second, rows(0, 0)));
  for (const Points2DView& view : {Points2DView(rows), Points2DView(columns), Points2DView(wide.rightCols(2))})
    CHECK(view.matrix() == rows);
  CHECK(Points2DView(every_second).matrix().row(1) == rows.row(2));
  CHECK(Points2DView(rows.data(), 3).matrix() == rows);
  const ValuesView second = rows.col(1);
  CHECK(second.matrix() == rows.col(1));
  CHECK(&second.matrix().coeffRef(1) == &rows(1, 1));
}

TEST_CASE("views keep temporaries alive") {
  RowMajor moved = Some();
  const double* memory = moved.data();
  Points2DView copy;
  {
    const Points2DView view = std::move(moved);
    copy = view;
  }
  CHECK(copy.matrix().data() == memory);
  CHECK(copy.matrix() == Some());
  CHECK(Points2DView(2.0 * copy.matrix()).matrix() == 2.0 * Some());
  const Eigen::MatrixXf single = Some().cast<float>();
  CHECK(Points2DView(single).matrix() == Some());
  CHECK(Points2DView(Some()(std::vector<int>{2, 0}, Eigen::all)).matrix().row(0) == Some().row(2));
}

TEST_CASE("views refuse other shapes") {
  const std::vector<Eigen::Vector2d> points = {{1.0, 2.0}, {3.0, 4.0}, {5.0, 6.0}};
  CHECK(Points2DView(points).matrix() == Some());
  CHECK(Points2DView().empty());
  CHECK(Points2DView(Eigen::MatrixXd()).rows() == 0);
  CHECK_THROWS_AS(Points2DView(Eigen::MatrixXd::Zero(4, 3)), std::invalid_argument);
}

}  // namespace
}  // namespace diffsac
