#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "lab/files/hdf5_numbers.h"

namespace diffsac {

inline const H5::StrType& Hdf5TextType() {
  static const H5::StrType type(H5::PredType::C_S1, H5T_VARIABLE);
  return type;
}

/// An attribute.
inline void PutText(const H5::H5Object& object, const char* name, const std::string& text) {
  object.createAttribute(name, Hdf5TextType(), H5::DataSpace(H5S_SCALAR)).write(Hdf5TextType(), text);
}

template <class Matrix>
std::vector<double> NumbersOf(const Matrix& matrix) {
  return {matrix.data(), matrix.data() + matrix.size()};
}

/// `width` numbers a row; 0: a list, compressed where it is long.
template <class Value>
void PutNumbers(const H5::Group& group, const std::string& name, const std::vector<Value>& values,
                std::size_t width = 0) {
  constexpr hsize_t kChunk = 1 << 14;
  const H5::DSetCreatPropList properties = WithoutTimes();
  if (values.size() > kChunk && width == 0) {
    properties.setChunk(1, &kChunk);
    properties.setDeflate(4);
  }
  const std::vector<hsize_t> list = {values.size()};
  WriteNumbers(group, name, values.data(), width == 0 ? list : std::vector<hsize_t>{values.size() / width, width},
               properties);
}

inline void PutTexts(const H5::Group& group, const std::string& name, const std::vector<std::string>& texts) {
  const hsize_t count = texts.size();
  const H5::DataSet data = group.createDataSet(name, Hdf5TextType(), H5::DataSpace(1, &count), WithoutTimes());
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  if (count > 0) data.write(pointers.data(), Hdf5TextType());
}

/// Writes data sets of a group, each from what `get` says of every record.
template <class Record>
class Columns {
 public:
  Columns(const H5::Group& group, std::vector<const Record*> records) : group_(group), records_(std::move(records)) {}

  template <class Has>
  bool Any(const Has& has) const {
    return std::any_of(records_.begin(), records_.end(), [&](const Record* record) { return has(*record); });
  }
  /// A number or text a record.
  template <class Get>
  void Values(const std::string& name, const Get& get) const {
    using Value = decltype(get(*records_[0]));
    std::vector<Value> values;
    for (const Record* record : records_) values.push_back(get(*record));
    if constexpr (std::is_same_v<Value, std::string>)
      PutTexts(group_, name, values);
    else
      PutNumbers(group_, name, values);
  }
  /// A row of numbers a record, as wide as the widest and at least `width`; NaN where a record has none. Returns the
  /// width.
  template <class Get>
  std::size_t Rows(const std::string& name, std::size_t width, const Get& get) const {
    std::vector<std::vector<double>> rows;
    for (const Record* record : records_) width = std::max(width, rows.emplace_back(get(*record)).size());
    std::vector<double> all;
    for (std::vector<double>& row : rows) {
      row.resize(width, std::nan(""));
      all.insert(all.end(), row.begin(), row.end());
    }
    PutNumbers(group_, name, all, width);
    return width;
  }
  /// A list a record, one after the other, and NAME_end: where each ends, in rows of `width` values; 0: single ones.
  template <class Get>
  void Lists(const std::string& name, const Get& get, std::size_t width = 0) const {
    std::vector<std::int64_t> ends;
    std::size_t size = 0;
    for (const Record* record : records_)
      ends.push_back(static_cast<std::int64_t>((size += get(*record).size()) / std::max<std::size_t>(width, 1)));
    Flat(name, get, width);
    PutNumbers(group_, name + "_end", ends);
  }
  /// The lists alone.
  template <class Get>
  void Flat(const std::string& name, const Get& get, std::size_t width = 0) const {
    decltype(get(*records_[0])) all;
    for (const Record* record : records_) {
      const auto list = get(*record);
      all.insert(all.end(), list.begin(), list.end());
    }
    PutNumbers(group_, name, all, width);
  }

 private:
  const H5::Group& group_;
  std::vector<const Record*> records_;
};

}  // namespace diffsac
