#include "nanoweft/base/hdf5.hpp"

namespace nanoweft::h5 {

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

template <class T>
void writeArray(hid_t object, const char* name, hid_t stored, hid_t memory, const T* values,
                hsize_t count, bool scalar) {
  Handle space(scalar ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr), H5Sclose);
  Handle attribute(H5Acreate2(object, name, stored, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  H5Awrite(attribute, memory, values);
}

template <class T>
std::optional<std::vector<T>> readArray(hid_t object, const char* name, hid_t memory) {
  if (H5Aexists(object, name) <= 0) return std::nullopt;
  Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  Handle space(H5Aget_space(attribute), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  if (count < 0) return std::nullopt;
  std::vector<T> values(static_cast<std::size_t>(count));
  if (H5Aread(attribute, memory, values.data()) < 0) return std::nullopt;
  return values;
}

}  // namespace

void writeAttribute(hid_t object, const char* name, const std::string& text) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, text.size() + 1);
  H5Tset_cset(type, H5T_CSET_UTF8);
  Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  H5Awrite(attribute, type, text.c_str());
}

void writeAttribute(hid_t object, const char* name, const std::vector<double>& values) {
  writeArray(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data(), values.size(), false);
}

void writeAttribute(hid_t object, const char* name, const std::vector<std::int64_t>& values) {
  writeArray(object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, values.data(), values.size(), false);
}

void writeScalar(hid_t object, const char* name, double value) {
  writeArray(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value, 1, true);
}

void writeScalar(hid_t object, const char* name, std::int64_t value) {
  writeArray(object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value, 1, true);
}

std::optional<std::string> readText(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return std::nullopt;
  Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  Handle type(H5Aget_type(attribute), H5Tclose);
  if (H5Tget_class(type) != H5T_STRING) return std::nullopt;
  if (H5Tis_variable_str(type) > 0) {
    Handle memory(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(memory, H5T_VARIABLE);
    H5Tset_cset(memory, H5Tget_cset(type));
    char* text = nullptr;
    if (H5Aread(attribute, memory, &text) < 0 || !text) return std::nullopt;
    std::string result = text;
    H5free_memory(text);
    return result;
  }
  std::string text(H5Tget_size(type), '\0');
  if (H5Aread(attribute, type, text.data()) < 0) return std::nullopt;
  return text.substr(0, text.find('\0'));
}

std::optional<std::vector<double>> readReals(hid_t object, const char* name) {
  return readArray<double>(object, name, H5T_NATIVE_DOUBLE);
}

std::optional<std::vector<std::int64_t>> readIntegers(hid_t object, const char* name) {
  return readArray<std::int64_t>(object, name, H5T_NATIVE_INT64);
}

}  // namespace nanoweft::h5
