#include "diffsac/report/svg_fits.h"

#include <catch2/catch.hpp>
#include <regex>

#include "diffsac/generators/synthetic.h"

namespace diffsac {

TEST_CASE("all points of a fit are within its picture, which they fill") {
  SyntheticOptions options;
  KeptFit fit{};
  fit.example = MakeSynthetic(Task::kLine, options, 1)->Get(0);
  for (const double stretch : {1.0, 5.0, 0.2}) {
    KeptFit wide = fit;
    wide.example.problem.points.col(0) *= stretch;
    const std::string svg = SvgOfFit(wide);
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    int dots = 0;
    const std::regex dot("M([-0-9.]+) ([-0-9.]+)h0");
    for (std::sregex_iterator it(svg.begin(), svg.end(), dot), end; it != end; ++it, ++dots) {
      const double x = std::stod((*it)[1]), y = std::stod((*it)[2]);
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
    CAPTURE(stretch);
    CHECK(dots == wide.example.problem.points.rows());
    CHECK((left > 5.0 && right < 395.0 && top > 5.0 && bottom < 335.0));
    CHECK((right - left > 370.0 || bottom - top > 310.0));
  }
}

TEST_CASE("y is upwards, but for points of an image") {
  KeptFit fit{};
  fit.example.problem.points.resize(2, 2);
  fit.example.problem.points << 0, 0, 0, 1;
  const auto first_below = [](const std::string& svg) {
    const std::regex dots("M([-0-9.]+) ([-0-9.]+)h0M([-0-9.]+) ([-0-9.]+)h0");
    std::smatch match;
    REQUIRE(std::regex_search(svg, match, dots));
    return std::stod(match[2]) > std::stod(match[4]);
  };
  CHECK(first_below(SvgOfFit(fit)));
  fit.example.problem.task = Task::kAbsolutePose;
  fit.example.problem.points.resize(2, 5);
  fit.example.problem.points << 0, 0, 0, 10, 10, 0, 0, 0, 10, 20;
  CHECK_FALSE(first_below(SvgOfFit(fit)));
}

}  // namespace diffsac
