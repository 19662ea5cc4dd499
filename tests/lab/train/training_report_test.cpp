#include "lab/train/training_report.h"

#include <catch2/catch.hpp>

namespace diffsac {
namespace {

using Catch::Contains;

TEST_CASE("a training's page has its curves, values and configuration, whatever these hold") {
  const std::string html = TrainingReportHtml("Training of <x>", {"loss_a", "learning_rate", "mAA@0.5deg"},
                                              {"10,0.5,0.001,", "20,0.25,0.001,0.4", "30,0.125,0.0005,0.6"},
                                              "name: </pre><script>alert(1)</script>\n", "png", false);
  CHECK_THAT(html, Contains("Training of &lt;x&gt;") && !Contains("<script>alert") && Contains("To iteration 30."));
  CHECK_THAT(html, Contains("src=\"data:image/png;base64,cG5n\"") && Contains("mAA@0.5deg") && Contains("0.125"));
  CHECK_THAT(html, !Contains("http:"));
}

TEST_CASE("a training that has not measured yet has a page as well") {
  CHECK_THAT(TrainingReportHtml("t", {"loss"}, {}, "", "", true), Contains("Nothing measured yet."));
}

}  // namespace
}  // namespace diffsac
