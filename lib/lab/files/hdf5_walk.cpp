#include "lab/files/hdf5_walk.h"

#include <algorithm>
#include <cstdlib>

#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

constexpr hsize_t kMostIndexed = 64;               // names that are asked for by their number
constexpr hsize_t kMostAttributeValues = 1 << 20;  // what CountOf allows

/// Called for each error of the library's, in place of printing it.
herr_t NoteRefusal(hid_t stack, void* refused) {
  const auto note = [](unsigned, const H5E_error2_t* error, void* out) -> herr_t {
    if (error->min_num == H5E_NOSPACE || error->min_num == H5E_CANTALLOC) *static_cast<bool*>(out) = true;
    return 0;
  };
  return H5Ewalk2(stack, H5E_WALK_UPWARD, note, refused);
}

hid_t VariableText() {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  return type;
}

bool IsText(hid_t type) { return H5Tget_class(type) == H5T_STRING; }

void ReadValues(hid_t data_set, hsize_t* budget) {
  hsize_t count = 0;
  if (WhyRefused(data_set, &count) != nullptr || count == 0) return;
  const hid_t type = H5Dget_type(data_set), space = H5Dget_space(data_set);
  const hsize_t bytes = count * std::max<hsize_t>(H5Tget_size(type), sizeof(double));
  void* values = bytes <= *budget ? std::calloc(count, sizeof(double)) : nullptr;
  if (values != nullptr) {
    *budget -= bytes;
    const bool text = IsText(type);
    const hid_t wanted = text ? VariableText() : H5Tcopy(H5T_NATIVE_DOUBLE);
    if (H5Dread(data_set, wanted, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0 && text)
      H5Dvlen_reclaim(wanted, space, H5P_DEFAULT, values);
    H5Tclose(wanted);
    std::free(values);
  }
  H5Sclose(space);
  H5Tclose(type);
}

herr_t ReadAttribute(hid_t object, const char* name, const H5A_info_t*, void*) {
  const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
  if (attribute < 0) return 0;
  const hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  const hsize_t size = std::max<hsize_t>(H5Tget_size(type), sizeof(double));
  const bool read = count > 0 && static_cast<hsize_t>(count) <= kMostAttributeValues && size <= kMostAttributeValues;
  void* values = read ? std::calloc(static_cast<std::size_t>(count), size) : nullptr;
  if (values != nullptr) {
    const bool text = IsText(type);
    if (H5Aread(attribute, text ? type : H5T_NATIVE_DOUBLE, values) >= 0 && text && H5Tis_variable_str(type) > 0)
      H5Dvlen_reclaim(type, space, H5P_DEFAULT, values);
    std::free(values);
  }
  H5Sclose(space);
  H5Tclose(type);
  H5Aclose(attribute);
  return 0;
}

void AskForKind(hid_t group, const char* name) {
  H5O_info_t info;
#if H5_VERSION_GE(1, 12, 0)
  H5Oget_info_by_name(group, name, &info, H5O_INFO_ALL, H5P_DEFAULT);
#else
  H5Oget_info_by_name(group, name, &info, H5P_DEFAULT);
#endif
}

void AskByNumber(hid_t group) {
  H5G_info_t info;
  if (H5Gget_info(group, &info) < 0) return;
  for (hsize_t i = 0; i < std::min(info.nlinks, kMostIndexed); ++i)
    H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, nullptr, 0, H5P_DEFAULT);
}

void ReadObject(hid_t object, hsize_t* budget) {
  hsize_t first = 0;
  H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, &first, ReadAttribute, nullptr);
  const H5I_type_t kind = H5Iget_type(object);
  if (kind == H5I_DATASET) ReadValues(object, budget);
  if (kind == H5I_GROUP) AskByNumber(object);
}

herr_t VisitLink(hid_t group, const char* name, const H5L_info_t*, void* budget) {
  AskForKind(group, name);
  const hid_t object = H5Oopen(group, name, H5P_DEFAULT);
  if (object < 0) return 0;
  ReadObject(object, static_cast<hsize_t*>(budget));
  H5Oclose(object);
  return 0;
}

}  // namespace

bool WalkHdf5(const char* path, hid_t access, hsize_t budget) {
  bool refused = false;
  H5Eset_auto2(H5E_DEFAULT, NoteRefusal, &refused);
  const bool alone = H5Fget_obj_count(static_cast<hid_t>(H5F_OBJ_ALL), H5F_OBJ_FILE) <= 0;
  const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, access);
  if (file >= 0) {
    const hid_t root = H5Gopen2(file, "/", H5P_DEFAULT);
    if (root >= 0) ReadObject(root, &budget);
    H5Lvisit(file, H5_INDEX_NAME, H5_ITER_INC, VisitLink, &budget);
    if (root >= 0) H5Gclose(root);
    H5Fclose(file);
  }
  // What the library does when the program ends. Not where other files are open, which are the parent's to write.
  if (alone) H5close();
  return !refused;
}

}  // namespace diffsac
