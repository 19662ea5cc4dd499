#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace diffsac {

/// CRC-32C (Castagnoli) of bytes: of "123456789" 0xE3069283 (RFC 3720, B.4).
std::uint32_t Crc32c(std::string_view bytes);

/// Named numbers of one iteration.
using Scalars = std::vector<std::pair<std::string, double>>;

/// What TensorBoard shows of one iteration.
struct ScalarEvent {
  double wall_time = 0.0;      ///< Seconds since 1970.
  std::int64_t iteration = 0;  ///< The step of the axis.
  Scalars scalars;             ///< Stored as 32-bit floats.
};

/// The bytes of one record (TFRecord: length, data, each with its masked checksum): an event as TensorBoard's protocol
/// buffer has it, or what a file begins with.
std::string EventRecord(const ScalarEvent& event);
std::string VersionRecord(double wall_time);

/// How many of these bytes, from the beginning, are whole records of events up to an iteration.
std::size_t WholeRecords(std::string_view bytes, std::int64_t last_iteration);

/// A file of scalars for TensorBoard. It grows by a record at a time, so that TensorBoard can follow it: a process that
/// is killed may leave half a record, which the next one removes. Throws Error, naming the file, when it cannot be
/// written.
class EventFile {
 public:
  /// Of an earlier run in the same file the events up to `last_iteration` stay; 0: none. Nothing is written yet.
  EventFile(std::string path, std::int64_t last_iteration);
  ~EventFile();
  EventFile(const EventFile&) = delete;
  EventFile& operator=(const EventFile&) = delete;

  /// Writes what stays, whole or not at all.
  void Begin();
  /// Appends an event of now. NaN is left out. Begin is called first where it was not.
  void Add(std::int64_t iteration, const Scalars& scalars);

 private:
  std::string path_, kept_;
  int descriptor_ = -1;
};

}  // namespace diffsac
