#include "diffsac/guidance/diffusion/time_grid.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/core/status.h"
#include "guidance/dummy_model.h"

using namespace diffsac;

namespace {

constexpr double kNoClipping = -std::numeric_limits<double>::infinity();

TimeGrid Grid(const NoiseSchedule& schedule, int steps, const char* spacing, const char* final_sigma = "zero",
              double clipping = kNoClipping) {
  return MakeTimeGrid(schedule,
                      {steps, FromString<TimestepSpacing>(spacing), FromString<FinalSigma>(final_sigma), clipping});
}

/// Without the end.
std::vector<double> Timesteps(const TimeGrid& grid) {
  std::vector<double> t;
  for (std::size_t i = 0; i + 1 < grid.size(); ++i) t.push_back(grid[i].t);
  return t;
}

}  // namespace

TEST_CASE("timesteps are those of diffusers") {
  const auto hundred = MakeSchedule("cosine");
  const auto thousand = MakeSchedule("linear", 1000);
  CHECK(Timesteps(Grid(hundred, 5, "linspace")) == std::vector<double>{99, 79, 59, 40, 20});
  CHECK(Timesteps(Grid(hundred, 5, "trailing")) == std::vector<double>{99, 79, 59, 39, 19});
  CHECK(Timesteps(Grid(thousand, 10, "linspace")) ==
        std::vector<double>{999, 899, 799, 699, 599, 500, 400, 300, 200, 100});
  CHECK(Timesteps(Grid(thousand, 10, "leading")) ==
        std::vector<double>{900, 810, 720, 630, 540, 450, 360, 270, 180, 90});
}

TEST_CASE("the last point is clean data or index 0") {
  const auto schedule = MakeSchedule("cosine");
  const auto zero = Grid(schedule, 5, "linspace", "zero").back();
  CHECK(zero.t == -1.0);
  CHECK(zero.alpha == 1.0);
  CHECK(zero.sigma == 0.0);
  CHECK(zero.lambda == std::numeric_limits<double>::infinity());
  const auto sigma_min = Grid(schedule, 5, "linspace", "sigma_min").back();
  CHECK(sigma_min.t == 0.0);
  CHECK(sigma_min.sigma == schedule.sigma(0));
}

TEST_CASE("lambda rises along every grid, for any number of steps") {
  const char* kind = GENERATE("cosine", "linear");
  const char* spacing = GENERATE("linspace", "leading", "trailing");
  const double clipping = GENERATE(kNoClipping, -5.1, 1.0);
  const auto schedule = MakeSchedule(kind, 20);
  for (int steps = 1; steps <= 20; ++steps) {
    const auto grid = Grid(schedule, steps, spacing, "zero", clipping);
    REQUIRE(grid.size() >= 2);
    CHECK(static_cast<int>(grid.size()) <= steps + 1);
    for (std::size_t i = 0; i < grid.size(); ++i) {
      CHECK(grid[i].alpha * grid[i].alpha + grid[i].sigma * grid[i].sigma == Approx(1.0));
      if (i > 0) CHECK(grid[i].lambda > grid[i - 1].lambda);
      if (i + 1 < grid.size()) CHECK((grid[i].t >= 0.0 && grid[i].t <= 19.0));
    }
  }
}

TEST_CASE("as many steps as the schedule has visit every index once") {
  const auto schedule = MakeSchedule("cosine");
  for (const char* spacing : {"linspace", "leading", "trailing"}) {
    const auto t = Timesteps(Grid(schedule, 100, spacing));
    REQUIRE(t.size() == 100);
    for (int i = 0; i < 100; ++i) CHECK(t[i] == 99 - i);
  }
}

TEST_CASE("clipping leaves out the noisiest timesteps") {
  const auto schedule = MakeSchedule("cosine");  // λ is −4.2 at 98 and −7.6 at 99
  CHECK(Timesteps(Grid(schedule, 5, "linspace", "zero", -5.1)).front() == 98);
  CHECK(Timesteps(Grid(schedule, 100, "linspace", "zero", -5.1)).size() == 99);
  CHECK(Timesteps(Grid(MakeSchedule("linear"), 5, "linspace", "zero", -5.1)).front() == 99);
}

TEST_CASE("bad grids are errors") {
  const auto schedule = MakeSchedule("cosine");
  CHECK_THROWS_AS(Grid(schedule, 0, "linspace"), Error);
  CHECK_THROWS_AS(Grid(schedule, 101, "linspace"), Error);
  CHECK_THROWS_AS(Grid(schedule, 5, "quadratic"), Error);
  CHECK_THROWS_AS(Grid(schedule, 5, "linspace", "small"), Error);
  CHECK_THROWS_AS(Grid(schedule, 5, "linspace", "zero", std::nan("")), Error);
}
