#include "diffsac/core/status.h"

namespace diffsac {

std::string_view ToString(Status status) {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kTooFewPoints:
      return "too_few_points";
    case Status::kDegenerate:
      return "degenerate";
    case Status::kNoModel:
      return "no_model";
  }
  return "unknown";
}

}  // namespace diffsac
