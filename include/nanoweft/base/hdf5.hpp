/// HDF5 handles that close themselves, and attributes in one line. HDF5 opens, creates and writes
/// are collective over the file's communicator unless said otherwise.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace nanoweft::h5 {

/// An HDF5 id with the function that closes it.
class Handle {
 public:
  Handle() = default;
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }
  bool valid() const { return id_ >= 0; }
  /// Closes now; false when that failed.
  bool close() {
    const hid_t id = std::exchange(id_, -1);
    return id < 0 || close_(id) >= 0;
  }

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

/// Is it a whole number that has a place in 64 bits?
bool isWhole(double x);

/// Keeps HDF5 from printing its error stack: errors become our own lines.
void silence();

/// Innermost reason on HDF5's error stack.
std::string lastError();

// False on failure.
bool writeAttribute(hid_t object, const char* name, const std::string& text);
bool writeAttribute(hid_t object, const char* name, const std::vector<double>& values);
bool writeAttribute(hid_t object, const char* name, const std::vector<std::int64_t>& values);
bool writeScalar(hid_t object, const char* name, double value);
bool writeScalar(hid_t object, const char* name, std::int64_t value);

/// One text; without the blanks of a type that is padded with them. Empty when the attribute is
/// missing, no text, or several.
std::optional<std::string> readText(hid_t object, const char* name);
/// Several texts: an array of them, or one with commas between them. Empty when the attribute is
/// missing or no text.
std::optional<std::vector<std::string>> readTexts(hid_t object, const char* name);
/// Empty when the attribute is missing, holds no numbers, or more than a file may hold.
std::optional<std::vector<double>> readReals(hid_t object, const char* name);
/// Also of real numbers that are whole. Empty when one is not, or has no place in 64 bits.
std::optional<std::vector<std::int64_t>> readIntegers(hid_t object, const char* name);

}  // namespace nanoweft::h5
