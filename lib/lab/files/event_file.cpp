#include "lab/files/event_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>

#include "diffsac/core/status.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

static_assert(std::endian::native == std::endian::little, "the byte order of the machine is assumed below");

constexpr std::size_t kHead = 12, kTail = 4;  // Length and its checksum; the data's checksum.

constexpr std::array<std::uint32_t, 256> MakeTable() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) != 0 ? 0x82F63B78U : 0U);
    table[i] = value;
  }
  return table;
}

/// As TFRecord stores checksums.
std::uint32_t Masked(std::uint32_t checksum) { return std::rotr(checksum, 15) + 0xA282EAD8U; }

template <class Value>
std::string Bytes(Value value) {
  std::string bytes(sizeof(Value), '\0');
  std::memcpy(bytes.data(), &value, sizeof(Value));
  return bytes;
}

template <class Value>
Value ValueAt(std::string_view bytes, std::size_t at) {
  Value value;
  std::memcpy(&value, bytes.data() + at, sizeof(Value));
  return value;
}

std::string Record(const std::string& data) {
  const std::string length = Bytes(static_cast<std::uint64_t>(data.size()));
  return length + Bytes(Masked(Crc32c(length))) + data + Bytes(Masked(Crc32c(data)));
}

// Protocol buffers: numbers of fields and wire types of tensorflow/core/util/event.proto and framework/summary.proto.
constexpr char kEventTime = 0x09, kEventStep = 0x10, kEventVersion = 0x1A, kEventSummary = 0x2A;
constexpr char kSummaryValue = 0x0A, kValueTag = 0x0A, kValueNumber = 0x15;

std::string Varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 128; value >>= 7) bytes += static_cast<char>(value | 128);
  return bytes + static_cast<char>(value);
}

std::string Field(char tag, const std::string& content) { return tag + Varint(content.size()) + content; }

/// The step of an event that EventRecord made; nothing for other bytes. An event without a step is of step 0.
std::optional<std::int64_t> StepOf(std::string_view event) {
  constexpr std::size_t kTime = 9;
  if (event.size() < kTime || event[0] != kEventTime) return std::nullopt;
  if (event.size() == kTime || event[kTime] != kEventStep) return 0;
  std::uint64_t step = 0;
  for (std::size_t at = kTime + 1, shift = 0; at < event.size() && shift < 64; ++at, shift += 7) {
    step |= static_cast<std::uint64_t>(event[at] & 127) << shift;
    if ((event[at] & 128) == 0) return static_cast<std::int64_t>(step);
  }
  return std::nullopt;
}

/// The data of the record that begins here, where it is whole.
std::optional<std::string_view> WholeRecord(std::string_view bytes) {
  if (bytes.size() < kHead + kTail) return std::nullopt;
  const auto length = ValueAt<std::uint64_t>(bytes, 0);
  if (length > bytes.size() - kHead - kTail || ValueAt<std::uint32_t>(bytes, 8) != Masked(Crc32c(bytes.substr(0, 8))))
    return std::nullopt;
  const std::string_view data = bytes.substr(kHead, length);
  if (ValueAt<std::uint32_t>(bytes, kHead + length) != Masked(Crc32c(data))) return std::nullopt;
  return data;
}

double Now() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

}  // namespace

std::uint32_t Crc32c(std::string_view bytes) {
  static constexpr auto kTable = MakeTable();
  std::uint32_t checksum = ~0U;
  for (const char c : bytes) checksum = (checksum >> 8) ^ kTable[(checksum ^ static_cast<unsigned char>(c)) & 255];
  return ~checksum;
}

std::string EventRecord(const ScalarEvent& event) {
  std::string summary;
  for (const auto& [name, value] : event.scalars)
    summary += Field(kSummaryValue, Field(kValueTag, name) + kValueNumber + Bytes(static_cast<float>(value)));
  return Record(kEventTime + Bytes(event.wall_time) + kEventStep + Varint(static_cast<std::uint64_t>(event.iteration)) +
                Field(kEventSummary, summary));
}

std::string VersionRecord(double wall_time) {
  return Record(kEventTime + Bytes(wall_time) + Field(kEventVersion, "brain.Event:2"));
}

std::size_t WholeRecords(std::string_view bytes, std::int64_t last_iteration) {
  std::size_t at = 0;
  while (const auto data = WholeRecord(bytes.substr(at))) {
    const auto step = StepOf(*data);
    if (!step || *step > last_iteration) break;
    at += kHead + data->size() + kTail;
  }
  return at;
}

EventFile::EventFile(std::string path, std::int64_t last_iteration) : path_(std::move(path)) {
  if (last_iteration > 0 && std::filesystem::exists(path_)) {
    kept_ = ReadFile(path_);
    kept_.resize(WholeRecords(kept_, last_iteration));
  }
  if (kept_.empty()) kept_ = VersionRecord(Now());
}

EventFile::~EventFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void EventFile::Begin() {
  if (descriptor_ >= 0) return;
  WriteFileAtomically(path_, kept_);
  kept_.clear();
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (descriptor_ < 0) throw Error("cannot write '" + path_ + "': " + std::strerror(errno));
}

void EventFile::Add(std::int64_t iteration, const Scalars& scalars) {
  Begin();
  ScalarEvent event{Now(), iteration, {}};
  for (const auto& scalar : scalars)
    if (!std::isnan(scalar.second)) event.scalars.push_back(scalar);
  const std::string record = EventRecord(event);
  std::string_view rest = record;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw Error("cannot write '" + path_ + "': " + std::strerror(errno));
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace diffsac
