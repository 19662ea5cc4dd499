#include "fuzz/hdf5_edits.h"

#include <H5Cpp.h>

#include <algorithm>
#include <mutex>
#include <vector>

#include "diffsac/core/random.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac::testing {
namespace {

constexpr const char* kNewNames[] = {"x", "a", "points", "a/points", "a/b/points", "a.png", "im_000-im_001", "q-"};

std::vector<std::string> PathsIn(const H5::H5File& file) {
  std::vector<std::string> paths;
  const auto append = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->push_back(name);
    return 0;
  };
  H5Lvisit(file.getId(), H5_INDEX_NAME, H5_ITER_INC, append, &paths);
  return paths;
}

std::vector<std::string> AttributesOf(const H5::H5Object& object) {
  std::vector<std::string> names;
  for (int i = 0; i < object.getNumAttrs(); ++i)
    names.push_back(H5::Attribute(object.openAttribute(static_cast<unsigned>(i))).getName());
  return names;
}

H5::DataType ReadType(ByteReader* reader) {
  switch (reader->Below(12)) {
    case 0:
      return H5::PredType::IEEE_F32BE;
    case 1:
      return H5::PredType::STD_I64LE;
    case 2:
      return H5::PredType::STD_U8LE;
    case 3:
      return H5::PredType::STD_U64BE;
    case 4:
      return H5::StrType(H5::PredType::C_S1, static_cast<std::size_t>(1 + reader->Below(9)));
    case 5:
      return H5::StrType(H5::PredType::C_S1, H5T_VARIABLE);
    case 6: {
      H5::CompType type(std::size_t{16});
      type.insertMember("v", 8, H5::PredType::IEEE_F64LE);
      return type;
    }
    case 7:
      return H5::ArrayType(H5::PredType::IEEE_F64LE, 1, std::vector<hsize_t>{3}.data());
    case 8:
      return H5::PredType::STD_REF_OBJ;
    default:
      return H5::PredType::IEEE_F64LE;
  }
}

// Mostly small; now and then what no memory holds. `huge`: it must not be written.
H5::DataSpace ReadSpace(ByteReader* reader, bool* huge) {
  constexpr hsize_t kHuge[] = {hsize_t{1} << 20, hsize_t{1} << 24, hsize_t{1} << 31, hsize_t{1} << 40,
                               hsize_t{1} << 60};
  const int kind = reader->Below(16);
  if (kind == 0) return H5::DataSpace(H5S_NULL);
  if (kind == 1) return H5::DataSpace(H5S_SCALAR);
  constexpr int kSmall[] = {0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 12, 18};
  std::vector<hsize_t> sizes(static_cast<std::size_t>(1 + reader->Below(3)));
  for (hsize_t& size : sizes) size = static_cast<hsize_t>(kSmall[reader->Below(12)]);
  *huge = reader->Below(6) == 0;
  if (*huge) sizes[0] = kHuge[reader->Below(5)];
  return H5::DataSpace(static_cast<int>(sizes.size()), sizes.data());
}

H5::DSetCreatPropList ReadLayout(ByteReader* reader, const H5::DataSpace& space, bool huge) {
  H5::DSetCreatPropList properties;
  const int kind = reader->Below(8);
  if (huge || kind < 3) {
    if (space.getSimpleExtentNdims() < 1) return properties;
    // Late allocation: what is never written takes no room.
    std::vector<hsize_t> chunk(static_cast<std::size_t>(space.getSimpleExtentNdims()), 1);
    chunk[0] = kind == 0 ? hsize_t{1} << 28 : static_cast<hsize_t>(1 + reader->Below(64));
    properties.setChunk(static_cast<int>(chunk.size()), chunk.data());
    if (kind == 1) properties.setDeflate(4);
  } else if (kind == 3) {
    properties.setExternal("/dev/zero", 0, H5F_UNLIMITED);
  }
  return properties;
}

// Numbers where the type takes some.
template <class Write>
void WriteValues(ByteReader* reader, const H5::DataType& type, const H5::DataSpace& space, const Write& write) {
  const H5T_class_t kind = type.getClass();
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) return;
  std::vector<double> values(static_cast<std::size_t>(std::max<hssize_t>(space.getSimpleExtentNpoints(), 0)));
  for (double& value : values) value = reader->Number();
  if (!values.empty()) write(values.data());
}

void PutDataSet(const H5::H5File& file, const std::string& path, ByteReader* reader) {
  const H5::DataType type = ReadType(reader);
  bool huge = false;
  const H5::DataSpace space = ReadSpace(reader, &huge);
  const H5::DataSet data = file.createDataSet(path, type, space, ReadLayout(reader, space, huge));
  if (huge || reader->Below(8) == 0 || data.getCreatePlist().getExternalCount() > 0) return;
  WriteValues(reader, type, space, [&](const double* values) { data.write(values, H5::PredType::NATIVE_DOUBLE); });
}

void PutAttribute(const H5::H5Object& object, ByteReader* reader) {
  constexpr const char* kNames[] = {"model", "inliers", "inlier_threshold", "id", "scene", "format", "method", "x"};
  std::vector<std::string> names = AttributesOf(object);
  if (names.empty() || reader->Flag()) names = {kNames[reader->Below(8)]};
  const std::string name = names[static_cast<std::size_t>(reader->Below(static_cast<int>(names.size())))];
  if (object.attrExists(name)) object.removeAttr(name);
  if (reader->Below(4) == 0) return;
  const H5::DataType type = ReadType(reader);
  bool huge = false;
  const H5::DataSpace space = ReadSpace(reader, &huge);
  if (huge) return;
  const H5::Attribute attribute = object.createAttribute(name, type, space);
  WriteValues(reader, type, space, [&](const double* values) { attribute.write(H5::PredType::NATIVE_DOUBLE, values); });
}

void EditAttributes(const H5::H5File& file, const std::string& path, ByteReader* reader) {
  if (reader->Below(4) == 0) return PutAttribute(file.openGroup("/"), reader);
  if (file.childObjType(path) == H5O_TYPE_GROUP) return PutAttribute(file.openGroup(path), reader);
  PutAttribute(file.openDataSet(path), reader);
}

void EditOnce(H5::H5File* file, const std::vector<std::string>& paths, ByteReader* reader) {
  const int which = reader->Below(static_cast<int>(paths.size()) + 8);
  const bool known = which < static_cast<int>(paths.size());
  const std::string path =
      known ? paths[static_cast<std::size_t>(which)] : kNewNames[which - static_cast<int>(paths.size())];
  const int what = reader->Below(11);
  if (what == 0) return EditAttributes(*file, path, reader);
  // An edit before this one may have removed it.
  H5Ldelete(file->getId(), path.c_str(), H5P_DEFAULT);
  switch (what) {
    case 1:
      return;
    case 2:
      file->createGroup(path);
      return;
    case 3:
      H5Lcreate_soft(reader->Flag() ? path.c_str() : "/nowhere", file->getId(), path.c_str(), H5P_DEFAULT, H5P_DEFAULT);
      return;
    case 4:
      H5Lcreate_hard(file->getId(), "/", file->getId(), path.c_str(), H5P_DEFAULT, H5P_DEFAULT);
      return;
    default:
      PutDataSet(*file, path, reader);
  }
}

}  // namespace

void EditHdf5(const std::string& path, ByteReader* reader) {
  const std::lock_guard lock(Hdf5Mutex());
  H5::Exception::dontPrint();
  H5::H5File file(path, H5F_ACC_RDWR);
  const std::vector<std::string> paths = PathsIn(file);
  for (int edits = reader->Below(7); edits > 0; --edits) {
    try {
      EditOnce(&file, paths, reader);
    } catch (const H5::Exception&) {
      // The library refuses it.
    }
  }
}

std::vector<std::string> EditSeeds(int choices) {
  std::vector<std::string> seeds;
  for (int choice = 0; choice < choices; ++choice) {
    seeds.emplace_back(1, static_cast<char>(choice));
    for (int i = 0; i < 3; ++i) {
      Rng rng = Rng(static_cast<std::uint64_t>(choice)).Fork("edits", static_cast<std::uint64_t>(i));
      seeds.push_back(seeds.back().substr(0, 1) + std::string(96, '\0'));
      for (std::size_t at = 1; at < seeds.back().size(); ++at) seeds.back()[at] = static_cast<char>(rng.Below(256));
    }
  }
  return seeds;
}

}  // namespace diffsac::testing
