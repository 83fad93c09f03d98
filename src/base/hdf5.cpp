#include "nanoweft/base/hdf5.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>

namespace nanoweft::h5 {

bool isWhole(double x) {
  // 2^63 itself has no place in 64 bits.
  return std::abs(x) < 0x1p63 && x == std::floor(x);
}

void silence() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

std::string lastError() {
  std::string reason;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned n, const H5E_error2_t* error, void* out) -> herr_t {
        if (n == 0 && error->desc) *static_cast<std::string*>(out) = error->desc;
        return 0;
      },
      &reason);
  return reason;
}

namespace {

/// No attribute of ours is nearly as long.
constexpr hssize_t mostAttributeElements = 1000000;
/// Attributes beyond this size do not fit into an object's header.
constexpr std::size_t mostFixedText = 32000;

template <class T>
bool writeArray(hid_t object, const char* name, hid_t stored, hid_t memory, const T* values,
                hsize_t count, bool scalar) {
  Handle space(scalar ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr), H5Sclose);
  Handle attribute(H5Acreate2(object, name, stored, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.valid() && H5Awrite(attribute, memory, values) >= 0;
}

/// An attribute with its type and number of elements.
struct Attribute {
  Handle id, type;
  H5T_class_t kind = H5T_NO_CLASS;
  hssize_t count = -1;

  Attribute(hid_t object, const char* name) {
    if (H5Aexists(object, name) <= 0) return;
    id = Handle(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
    type = Handle(H5Aget_type(id), H5Tclose);
    Handle space(H5Aget_space(id), H5Sclose);
    if (!type.valid() || !space.valid()) return;
    kind = H5Tget_class(type);
    count = H5Sget_simple_extent_npoints(space);
    if (count > mostAttributeElements) count = -1;
  }
  /// Enumerations are how h5py stores truth values.
  bool whole() const { return count >= 0 && (kind == H5T_INTEGER || kind == H5T_ENUM); }
  bool real() const { return count >= 0 && kind == H5T_FLOAT; }

  template <class T>
  std::optional<std::vector<T>> read(hid_t memory) const {
    std::vector<T> values(static_cast<std::size_t>(count));
    if (count > 0 && H5Aread(id, memory, values.data()) < 0) return std::nullopt;
    return values;
  }
};

}  // namespace

bool writeAttribute(hid_t object, const char* name, const std::string& text) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  const bool fixed = text.size() <= mostFixedText;
  H5Tset_size(type, fixed ? text.size() + 1 : H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const char* const start = text.c_str();
  const void* const bytes = fixed ? static_cast<const void*>(start) : &start;
  return attribute.valid() && H5Awrite(attribute, type, bytes) >= 0;
}

bool writeAttribute(hid_t object, const char* name, const std::vector<double>& values) {
  return writeArray(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data(), values.size(),
                    false);
}

bool writeAttribute(hid_t object, const char* name, const std::vector<std::int64_t>& values) {
  return writeArray(object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, values.data(), values.size(),
                    false);
}

bool writeScalar(hid_t object, const char* name, double value) {
  return writeArray(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value, 1, true);
}

bool writeScalar(hid_t object, const char* name, std::int64_t value) {
  return writeArray(object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value, 1, true);
}

std::optional<std::string> readText(hid_t object, const char* name) {
  const Attribute a(object, name);
  if (a.kind != H5T_STRING || a.count != 1) return std::nullopt;
  std::string result;
  if (H5Tis_variable_str(a.type) > 0) {
    Handle memory(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(memory, H5T_VARIABLE);
    H5Tset_cset(memory, H5Tget_cset(a.type));
    char* text = nullptr;
    if (H5Aread(a.id, memory, &text) < 0 || !text) return std::nullopt;
    result = text;
    H5free_memory(text);
  } else {
    result.resize(H5Tget_size(a.type));
    if (H5Aread(a.id, a.type, result.data()) < 0) return std::nullopt;
    result.resize(std::min(result.size(), result.find('\0')));
  }
  if (H5Tget_strpad(a.type) == H5T_STR_SPACEPAD) result.resize(result.find_last_not_of(' ') + 1);
  return result;
}

std::optional<std::vector<std::string>> readTexts(hid_t object, const char* name) {
  const Attribute a(object, name);
  if (a.kind != H5T_STRING || a.count < 1) return std::nullopt;
  std::vector<std::string> texts;
  if (a.count == 1) {
    const auto all = readText(object, name);
    if (!all) return std::nullopt;
    std::istringstream parts(*all);
    for (std::string part; std::getline(parts, part, ',');) texts.push_back(part);
    return texts;
  }
  const auto count = static_cast<std::size_t>(a.count);
  if (H5Tis_variable_str(a.type) > 0) {
    Handle memory(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(memory, H5T_VARIABLE);
    H5Tset_cset(memory, H5Tget_cset(a.type));
    std::vector<char*> pointers(count, nullptr);
    if (H5Aread(a.id, memory, pointers.data()) < 0) return std::nullopt;
    for (char* text : pointers) {
      texts.emplace_back(text ? text : "");
      if (text) H5free_memory(text);
    }
    return texts;
  }
  const std::size_t bytes = H5Tget_size(a.type);
  std::string all(bytes * count, '\0');
  if (H5Aread(a.id, a.type, all.data()) < 0) return std::nullopt;
  for (std::size_t k = 0; k < count; ++k) {
    std::string text = all.substr(k * bytes, bytes);
    text.resize(std::min(text.size(), text.find('\0')));
    if (H5Tget_strpad(a.type) == H5T_STR_SPACEPAD) text.resize(text.find_last_not_of(' ') + 1);
    texts.push_back(text);
  }
  return texts;
}

std::optional<std::vector<double>> readReals(hid_t object, const char* name) {
  const Attribute a(object, name);
  if (!a.real() && !a.whole()) return std::nullopt;
  return a.read<double>(H5T_NATIVE_DOUBLE);
}

std::optional<std::vector<std::int64_t>> readIntegers(hid_t object, const char* name) {
  const Attribute a(object, name);
  if (a.real()) {
    const auto reals = a.read<double>(H5T_NATIVE_DOUBLE);
    if (!reals || !std::ranges::all_of(*reals, isWhole)) return std::nullopt;
    return std::vector<std::int64_t>(reals->begin(), reals->end());
  }
  if (!a.whole()) return std::nullopt;
  auto values = a.read<std::int64_t>(H5T_NATIVE_INT64);
  // HDF5 clips what is too large.
  const bool clips = H5Tget_size(a.type) >= 8 && H5Tget_sign(a.type) == H5T_SGN_NONE;
  if (clips && values && std::ranges::find(*values, INT64_MAX) != values->end())
    return std::nullopt;
  return values;
}

}  // namespace nanoweft::h5
