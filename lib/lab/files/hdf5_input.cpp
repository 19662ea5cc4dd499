#include "lab/files/hdf5_input.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <set>

#include "diffsac/core/status.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

constexpr rlim_t kSeconds = 1, kBytesPerSecond = rlim_t{8} << 20;  // of the processor; reading takes a hundredth
constexpr rlim_t kMemory = rlim_t{1} << 30;                        // beside what the parent has
// Values that the child reads, in bytes: of larger files, or of such as are compressed beyond this, not all.
constexpr hsize_t kMostRead = hsize_t{512} << 20, kAlwaysRead = hsize_t{32} << 20, kDensest = 32;
// A child that no longer runs, but waits: for a lock that another thread of the parent had.
constexpr int kMostWaiting = 60;  // times its seconds
constexpr char kFinished = 'f';

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

/// Asks the library for all that our readers could ask for: names, kinds, attributes and values of at most `budget`
/// bytes, from opening to closing. What fails is passed over. False when memory was refused: what the library does with
/// more of it is not known then. Prints no errors. It calls only C functions of the library and allocates
/// nothing by itself but buffers, so that a child of a process with several threads may call it.
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

struct Child {
  const char* path;
  hid_t access;
  rlim_t size, memory;  // memory: 0 where it is not limited
  rlim_t seconds() const { return kSeconds + size / kBytesPerSecond; }
  hsize_t budget() const { return std::min<hsize_t>(kMostRead, kAlwaysRead + kDensest * size); }
};

void Limit(__rlimit_resource resource, rlim_t most) {
  rlimit limit{};
  if (::getrlimit(resource, &limit) != 0) return;
  limit.rlim_max = std::min(limit.rlim_max, most);
  limit.rlim_cur = std::min(limit.rlim_cur, limit.rlim_max);
  ::setrlimit(resource, &limit);
}

/// In the child: no core, no file, no word on the terminal, the system's own end of what crashes.
void Confine(const Child& child) {
  ::prctl(PR_SET_DUMPABLE, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  Limit(RLIMIT_CORE, 0);
  Limit(RLIMIT_FSIZE, 0);
  Limit(RLIMIT_CPU, child.seconds());
  if (child.memory > 0) Limit(RLIMIT_AS, child.memory);
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU, SIGALRM}) ::signal(signal, SIG_DFL);
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE}) ::signal(signal, SIG_IGN);  // the parent's to answer
  const int nowhere = ::open("/dev/null", O_RDWR);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
}

/// Only what a child of a process with several threads may do, and _exit: nothing of the parent's is flushed.
[[noreturn]] void Walk(const Child& child, int answer) {
  Confine(child);
  const bool within = WalkHdf5(child.path, child.access, child.budget());
  const bool told = within && ::write(answer, &kFinished, 1) == 1;
  ::_exit(told ? 0 : 1);
}

/// Whether the child said that it was done, before it ended or was waited for too long.
bool Finishes(int answer, rlim_t seconds) {
  const std::time_t end = std::time(nullptr) + static_cast<std::time_t>(kMostWaiting * seconds);
  for (;;) {
    pollfd ready{answer, POLLIN, 0};
    const int events = ::poll(&ready, 1, 1000);
    if (events == 0 && std::time(nullptr) > end) return false;
    if (events <= 0) continue;
    char said = 0;
    const ssize_t count = ::read(answer, &said, 1);
    if (count >= 0 || errno != EINTR) return count == 1;
  }
}

rlim_t MemoryLimit() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return 0;  // They reserve more than there is.
#else
  std::ifstream file("/proc/self/statm");
  rlim_t pages = 0;
  if (!(file >> pages)) return 0;
  return pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + kMemory;
#endif
}

void Check(const std::string& name, const Child& child) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw Error(name + ": cannot be checked: " + std::strerror(errno));
  const pid_t id = ::fork();
  if (id == 0) Walk(child, ends[1]);
  const int error = errno;
  ::close(ends[1]);
  const bool finished = id > 0 && Finishes(ends[0], child.seconds());
  ::close(ends[0]);
  if (id < 0) throw Error(name + ": cannot be checked: " + std::strerror(error));
  if (!finished) ::kill(id, SIGKILL);
  while (::waitpid(id, nullptr, 0) < 0 && errno == EINTR) {
  }
  if (!finished)
    throw Error(name + ": crashes the HDF5 library, or asks it for more time or memory than it can need: damaged");
}

/// Of a file as it is now; a file that changed has others.
using Identity = std::array<std::uint64_t, 7>;

Identity IdentityOf(const struct stat& file) {
  const auto number = [](auto value) { return static_cast<std::uint64_t>(value); };
  return {number(file.st_dev),         number(file.st_ino),          number(file.st_size),
          number(file.st_mtim.tv_sec), number(file.st_mtim.tv_nsec), number(file.st_ctim.tv_sec),
          number(file.st_ctim.tv_nsec)};
}

/// Clocks of file systems tick slowly: what was changed just now can change again and have the same times.
bool IsSettled(const struct stat& file) {
  constexpr std::time_t kTick = 2;
  return std::max(file.st_mtim.tv_sec, file.st_ctim.tv_sec) + kTick < std::time(nullptr);
}

void CheckOnce(const std::string& path) {
  static std::set<Identity> seen;  // Under the library's lock, as all of this.
  struct stat file {};
  // What is not there, or a folder, or a pipe: the library says so.
  if (::stat(path.c_str(), &file) != 0 || !S_ISREG(file.st_mode)) return;
  if (seen.contains(IdentityOf(file))) return;
  Check(path, {path.c_str(), H5P_DEFAULT, static_cast<rlim_t>(file.st_size), MemoryLimit()});
  if (IsSettled(file)) seen.insert(IdentityOf(file));
}

}  // namespace

H5::H5File OpenHdf5(const std::string& path) {
  CheckOnce(path);
  return H5::H5File(path, H5F_ACC_RDONLY);
}

H5::H5File OpenHdf5Bytes(const std::string& bytes, const std::string& name) {
  constexpr std::size_t kIncrement = 1 << 20;
  constexpr const char* kNoFile = "in memory";
  H5::FileAccPropList access;
  access.setCore(kIncrement, false);
  H5Pset_file_image(access.getId(), const_cast<char*>(bytes.data()), bytes.size());
  Check(name, {kNoFile, access.getId(), bytes.size(), MemoryLimit()});
  return H5::H5File(kNoFile, H5F_ACC_RDONLY, H5::FileCreatPropList::DEFAULT, access);
}

}  // namespace diffsac
