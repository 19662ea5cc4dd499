#include "lab/images/exif_focal.h"

#include <libexif/exif-data.h>
#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>

#if defined(DIFFSAC_HAS_LENSFUN)
#include <lensfun/lensfun.h>
#endif

namespace diffsac {
namespace {

// Of 36 mm by 24 mm.
constexpr double kFilmDiagonalMm = 43.26661531;

struct Unref {
  void operator()(ExifData* data) const { exif_data_unref(data); }
};

// The fields of one file; 0 for one that is not there or is no positive number.
class ExifFields {
 public:
  explicit ExifFields(const std::string& path) : data_(exif_data_new_from_file(path.c_str())) {}

  double Number(ExifTag tag) const {
    const ExifEntry* entry = data_ ? exif_data_get_entry(data_.get(), tag) : nullptr;
    if (entry == nullptr || entry->data == nullptr || entry->components < 1 ||
        entry->size < exif_format_get_size(entry->format))
      return 0.0;
    const ExifByteOrder order = exif_data_get_byte_order(data_.get());
    switch (entry->format) {
      case EXIF_FORMAT_SHORT:
        return exif_get_short(entry->data, order);
      case EXIF_FORMAT_LONG:
        return exif_get_long(entry->data, order);
      case EXIF_FORMAT_RATIONAL: {
        const ExifRational value = exif_get_rational(entry->data, order);
        return value.denominator > 0 ? static_cast<double>(value.numerator) / value.denominator : 0.0;
      }
      default:
        return 0.0;
    }
  }

  /// Of the first directory; empty where there is none.
  std::string Text(ExifTag tag) const {
    const ExifEntry* entry = data_ ? exif_content_get_entry(data_->ifd[EXIF_IFD_0], tag) : nullptr;
    if (entry == nullptr || entry->data == nullptr || entry->format != EXIF_FORMAT_ASCII) return "";
    std::string text(reinterpret_cast<const char*>(entry->data), entry->size);
    text.resize(std::min(text.find('\0'), text.size()));
    text.resize(text.find_last_not_of(' ') + 1);
    return text;
  }

 private:
  std::unique_ptr<ExifData, Unref> data_;
};

double MillimetresOf(double resolution_unit) {
  switch (static_cast<int>(resolution_unit)) {
    case 3:
      return 10.0;
    case 4:
      return 1.0;
    case 5:
      return 1e-3;
    default:
      return 25.4;
  }
}

double Longer(double width, double height) { return std::max(width, height); }
double Shape(double width, double height) { return Longer(width, height) / std::min(width, height); }

// 0: unknown.
double FocalPx(const ExifFields& fields, const ImageSize& size) {
  constexpr double kSameShape = 0.02;
  const double width = fields.Number(EXIF_TAG_PIXEL_X_DIMENSION), height = fields.Number(EXIF_TAG_PIXEL_Y_DIMENSION);
  const bool taken = width > 0.0 && height > 0.0;
  if (taken && std::abs(Shape(width, height) / Shape(size.width, size.height) - 1.0) > kSameShape) return 0.0;
  if (const double film_mm = fields.Number(EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM); film_mm > 0.0)
    return film_mm / kFilmDiagonalMm * std::hypot(size.width, size.height);
  const double focal_mm = fields.Number(EXIF_TAG_FOCAL_LENGTH);
  if (focal_mm > 0.0)
    if (const auto crop = CropFactor(fields.Text(EXIF_TAG_MAKE), fields.Text(EXIF_TAG_MODEL)))
      return focal_mm * *crop / kFilmDiagonalMm * std::hypot(size.width, size.height);
  const double per_unit = fields.Number(EXIF_TAG_FOCAL_PLANE_X_RESOLUTION);
  if (!taken || !(per_unit > 0.0)) return 0.0;
  const double per_mm = per_unit / MillimetresOf(fields.Number(EXIF_TAG_FOCAL_PLANE_RESOLUTION_UNIT));
  const double reduced = Longer(size.width, size.height) / Longer(width, height);
  return focal_mm * per_mm * reduced;
}

}  // namespace

std::optional<double> ExifFocalPx(const std::string& path, const ImageSize& size) {
  if (!size.known()) return std::nullopt;
  const double focal = FocalPx(ExifFields(path), size);
  const double share = focal / Longer(size.width, size.height);
  if (!(share >= 0.2 && share <= 50.0)) return std::nullopt;
  return focal;
}

std::string ExifCamera(const std::string& path) {
  const ExifFields fields(path);
  const std::string maker = fields.Text(EXIF_TAG_MAKE), model = fields.Text(EXIF_TAG_MODEL);
  const double focal_mm = fields.Number(EXIF_TAG_FOCAL_LENGTH);
  const double width = fields.Number(EXIF_TAG_PIXEL_X_DIMENSION), height = fields.Number(EXIF_TAG_PIXEL_Y_DIMENSION);
  if (model.empty() || !(focal_mm > 0.0) || !(width > 0.0) || !(height > 0.0)) return "";
  return maker + ", " + model + ", " + std::to_string(focal_mm) + " mm, " + std::to_string(Longer(width, height)) +
         " x " + std::to_string(std::min(width, height));
}

#if defined(DIFFSAC_HAS_LENSFUN)
namespace {

struct Destroy {
  void operator()(lfDatabase* database) const { lf_db_destroy(database); }
  void operator()(const lfCamera** cameras) const { lf_free(cameras); }
};

// The cameras that are installed with lensfun, read when they are first asked for.
class Cameras {
 public:
  Cameras() : database_(lf_db_new()) {
    if (database_ && lf_db_load(database_.get()) != LF_NO_ERROR) database_.reset();
  }

  std::optional<double> CropFactor(const std::string& maker, const std::string& model) {
    const std::lock_guard lock(mutex_);
    if (!database_) return std::nullopt;
    const std::unique_ptr<const lfCamera*, Destroy> found(
        lf_db_find_cameras(database_.get(), maker.c_str(), model.c_str()));
    if (!found || found.get()[0] == nullptr || !(found.get()[0]->CropFactor > 0.0F)) return std::nullopt;
    return found.get()[0]->CropFactor;
  }

 private:
  std::mutex mutex_;
  std::unique_ptr<lfDatabase, Destroy> database_;
};

}  // namespace
#endif

std::optional<double> CropFactor([[maybe_unused]] const std::string& maker, [[maybe_unused]] const std::string& model) {
  if (maker.empty() || model.empty()) return std::nullopt;
#if defined(DIFFSAC_HAS_LENSFUN)
  static Cameras cameras;
  return cameras.CropFactor(maker, model);
#else
  return std::nullopt;
#endif
}

}  // namespace diffsac
