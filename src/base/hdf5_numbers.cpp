#include "nanoweft/base/hdf5_numbers.hpp"

#include <algorithm>
#include <limits>
#include <type_traits>

#include "nanoweft/base/error.hpp"

namespace nanoweft::h5 {

namespace {

/// Rows that are converted at a time.
constexpr std::int64_t blockRows = 65536;

bool isWholeType(H5T_class_t kind) {
  // Enumerations are how h5py stores truth values.
  return kind == H5T_INTEGER || kind == H5T_ENUM;
}

/// The filters of a dataset that this HDF5 cannot undo, by name.
std::string missingFilter(hid_t creation) {
  for (int k = 0; k < H5Pget_nfilters(creation); ++k) {
    char name[80] = "";
    unsigned flags = 0, config = 0;
    std::size_t parameters = 0;
    const H5Z_filter_t filter = H5Pget_filter2(creation, static_cast<unsigned>(k), &flags,
                                               &parameters, nullptr, sizeof name, name, &config);
    if (filter < 0) return "a filter without a number";
    if (H5Zfilter_avail(filter) > 0 && H5Zget_filter_info(filter, &config) >= 0 &&
        (config & H5Z_FILTER_CONFIG_DECODE_ENABLED))
      continue;
    return format("the HDF5 filter %d%s%s", filter, name[0] ? " " : "", name);
  }
  return "";
}

/// Does the dataset take all of its numbers from this file?
bool isWholeInFile(hid_t creation) {
  return H5Pget_layout(creation) != H5D_VIRTUAL && H5Pget_external_count(creation) == 0;
}

/// Has every element been written?
bool allWritten(hid_t set, hid_t space, hid_t creation, const std::vector<hsize_t>& shape) {
  if (H5Pget_layout(creation) == H5D_COMPACT) return true;
  if (H5Pget_layout(creation) == H5D_CONTIGUOUS) return H5Dget_storage_size(set) > 0;
  hsize_t chunk[3] = {1, 1, 1}, present = 0, wanted = 1;
  const int dimensions = H5Pget_chunk(creation, 3, chunk);
  for (int d = 0; d < dimensions && d < 3; ++d)
    wanted *= (shape[static_cast<std::size_t>(d)] + chunk[d] - 1) / chunk[d];
  return H5Dget_num_chunks(set, space, &present) >= 0 && present == wanted;
}

/// Can a T hold all values of this type of whole numbers?
template <class T>
bool holds(hid_t stored) {
  const std::size_t bytes = H5Tget_size(stored);
  return H5Tget_sign(stored) == H5T_SGN_NONE ? bytes < sizeof(T) : bytes <= sizeof(T);
}

template <class T>
hid_t nativeType() {
  if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_NATIVE_INT64;
  if constexpr (std::is_same_v<T, std::int32_t>) return H5T_NATIVE_INT32;
  return H5T_NATIVE_INT8;
}

class Rows {
 public:
  Rows(hid_t group, const Expected& expected)
      : dimensions_(expected.dimensions()),
        columns_(expected.columns),
        depth_(expected.depth),
        set_(H5Dopen2(group, expected.name, H5P_DEFAULT), H5Dclose),
        space_(H5Dget_space(set_), H5Sclose),
        type_(H5Dget_type(set_), H5Tclose) {}
  hid_t type() const { return type_; }

  template <class T>
  bool read(std::int64_t begin, std::int64_t count, T* values) const {
    const hsize_t start[3] = {static_cast<hsize_t>(begin), 0, 0};
    const hsize_t extent[3] = {static_cast<hsize_t>(count), static_cast<hsize_t>(columns_),
                               static_cast<hsize_t>(depth_)};
    if (H5Sselect_hyperslab(space_, H5S_SELECT_SET, start, nullptr, extent, nullptr) < 0)
      return false;
    const Handle memory(H5Screate_simple(dimensions_, extent, nullptr), H5Sclose);
    return H5Dread(set_, nativeType<T>(), memory, space_, H5P_DEFAULT, values) >= 0;
  }

 private:
  int dimensions_, columns_, depth_;
  Handle set_, space_, type_;
};

/// Converts by way of `Wide`, which tells what does not fit.
template <class Wide, class T>
std::string readChecked(const Rows& rows, const Expected& expected, std::int64_t begin,
                        std::int64_t count, T* values) {
  const auto columns = static_cast<std::size_t>(expected.perRow());
  // HDF5 clips what is too large for the 64 bits that it is read into.
  const bool clips = std::is_same_v<Wide, std::int64_t> && !holds<std::int64_t>(rows.type());
  std::vector<Wide> block(static_cast<std::size_t>(std::min(count, blockRows)) * columns);
  for (std::int64_t done = 0; done < count; done += blockRows) {
    const std::int64_t now = std::min(blockRows, count - done);
    if (!rows.read(begin + done, now, block.data())) return "cannot be read (" + lastError() + ")";
    for (std::size_t k = 0; k < static_cast<std::size_t>(now) * columns; ++k) {
      const Wide x = block[k];
      bool right = true;
      if constexpr (std::is_same_v<Wide, double>)
        right = isWhole(x);
      else
        right = !clips || x != std::numeric_limits<Wide>::max();
      if (right) {
        const auto whole = static_cast<std::int64_t>(x);
        right = whole >= std::numeric_limits<T>::min() && whole <= std::numeric_limits<T>::max();
      }
      if (!right)
        return format("has %.17g in row %lld, which is no whole number of %d bits",
                      static_cast<double>(x),
                      static_cast<long long>(begin + done + static_cast<std::int64_t>(k / columns)),
                      static_cast<int>(8 * sizeof(T)));
      *values++ = static_cast<T>(x);
    }
  }
  return "";
}

std::string shapeOf(const Expected& expected) {
  std::string shape = "must have the shape [N";
  if (expected.dimensions() > 1) shape += format(", %d", expected.columns);
  if (expected.dimensions() > 2) shape += format(", %d", expected.depth);
  return shape + "]";
}

}  // namespace

Found find(hid_t group, const char* name) {
  if (H5Lexists(group, name, H5P_DEFAULT) <= 0) return Found::nothing;
  H5L_info_t link;
  if (H5Lget_info(group, name, &link, H5P_DEFAULT) < 0) return Found::other;
  if (link.type != H5L_TYPE_HARD && link.type != H5L_TYPE_SOFT) return Found::otherFile;
  if (H5Oexists_by_name(group, name, H5P_DEFAULT) <= 0) return Found::deadLink;
  const Handle object(H5Oopen(group, name, H5P_DEFAULT), H5Oclose);
  const H5I_type_t type = object.valid() ? H5Iget_type(object) : H5I_BADID;
  return type == H5I_GROUP ? Found::group : type == H5I_DATASET ? Found::dataset : Found::other;
}

Shape inspect(hid_t group, const Expected& expected) {
  Shape result;
  switch (find(group, expected.name)) {
    case Found::deadLink:
      result.problem = "is a link to nothing";
      return result;
    case Found::otherFile:
      result.problem = "is a link to another file; copy the data into this one";
      return result;
    case Found::dataset:
      break;
    default:
      result.problem = "is not a dataset";
      return result;
  }
  const Handle set(H5Dopen2(group, expected.name, H5P_DEFAULT), H5Dclose);
  const Handle type(H5Dget_type(set), H5Tclose), space(H5Dget_space(set), H5Sclose),
      creation(H5Dget_create_plist(set), H5Pclose);
  if (!set.valid() || !type.valid() || !space.valid() || !creation.valid()) {
    result.problem = "cannot be opened (" + lastError() + ")";
    return result;
  }
  const H5T_class_t kind = H5Tget_class(type);
  const int dimensions = H5Sget_simple_extent_ndims(space);
  std::vector<hsize_t> shape(static_cast<std::size_t>(std::max(dimensions, 3)), 0);
  H5Sget_simple_extent_dims(space, shape.data(), nullptr);
  if (kind != H5T_FLOAT && !isWholeType(kind))
    result.problem = expected.whole ? "must hold whole numbers" : "must hold numbers";
  else if (dimensions != expected.dimensions() ||
           (dimensions > 1 && shape[1] != static_cast<hsize_t>(expected.columns)) ||
           (dimensions > 2 && shape[2] != static_cast<hsize_t>(expected.depth)) ||
           shape[0] > static_cast<hsize_t>(std::numeric_limits<std::int64_t>::max()))
    result.problem = shapeOf(expected);
  else if (!isWholeInFile(creation))
    result.problem = "has its data in another file; copy them into this one";
  else if (const std::string filter = missingFilter(creation); !filter.empty())
    result.problem = "needs " + filter + ", which is not installed here";
  if (!result.problem.empty()) return result;
  result.rows = static_cast<std::int64_t>(shape[0]);
  result.written = result.rows == 0 || allWritten(set, space, creation, shape);
  return result;
}

template <class T>
std::string readRows(hid_t group, const Expected& expected, std::int64_t begin, std::int64_t count,
                     std::vector<T>& values) {
  values.resize(static_cast<std::size_t>(count * expected.perRow()));
  if (count == 0) return "";
  const Rows rows(group, expected);
  if constexpr (!std::is_same_v<T, double>) {
    if (H5Tget_class(rows.type()) == H5T_FLOAT)
      return readChecked<double>(rows, expected, begin, count, values.data());
    if (!holds<T>(rows.type()))
      return readChecked<std::int64_t>(rows, expected, begin, count, values.data());
  }
  return rows.read(begin, count, values.data()) ? "" : "cannot be read (" + lastError() + ")";
}

template std::string readRows(hid_t, const Expected&, std::int64_t, std::int64_t,
                              std::vector<double>&);
template std::string readRows(hid_t, const Expected&, std::int64_t, std::int64_t,
                              std::vector<std::int64_t>&);
template std::string readRows(hid_t, const Expected&, std::int64_t, std::int64_t,
                              std::vector<std::int32_t>&);
template std::string readRows(hid_t, const Expected&, std::int64_t, std::int64_t,
                              std::vector<std::int8_t>&);

}  // namespace nanoweft::h5
