#include "nanoweft/state/dataset_writer.hpp"

#include <algorithm>
#include <cstring>

#include "nanoweft/state/state_format.hpp"

namespace nanoweft {

namespace {

/// Rows that rank 0 holds at a time: whole chunks, which HDF5 then writes without reading them
/// again.
constexpr std::int64_t blockRows = 16 * chunkRows;
constexpr int tag = 7402;

/// A dataset that is being filled from its first row on.
class Filling {
 public:
  Filling(hid_t group, const char* name, hid_t stored, hid_t memory, std::vector<hsize_t> shape)
      : memory_(memory), shape_(std::move(shape)) {
    space_ = h5::Handle(H5Screate_simple(static_cast<int>(shape_.size()), shape_.data(), nullptr),
                        H5Sclose);
    h5::Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_obj_track_times(creation, false);
    if (shape_[0] > 0) {
      std::vector<hsize_t> chunk = shape_;
      chunk[0] = std::min<hsize_t>(chunk[0], chunkRows);
      H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
      H5Pset_fletcher32(creation);
    }
    set_ = h5::Handle(H5Dcreate2(group, name, stored, space_, H5P_DEFAULT, creation, H5P_DEFAULT),
                      H5Dclose);
  }
  bool valid() const { return set_.valid(); }

  bool append(const char* rows, std::int64_t count) {
    std::vector<hsize_t> start(shape_.size(), 0), extent = shape_;
    start[0] = static_cast<hsize_t>(next_);
    extent[0] = static_cast<hsize_t>(count);
    next_ += count;
    h5::Handle block(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr),
                     H5Sclose);
    H5Sselect_hyperslab(space_, H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr);
    return H5Dwrite(set_, memory_, block, space_, H5P_DEFAULT, rows) >= 0;
  }

 private:
  hid_t memory_;
  std::vector<hsize_t> shape_;
  h5::Handle space_, set_;
  std::int64_t next_ = 0;
};

}  // namespace

DatasetWriter::DatasetWriter(MPI_Comm comm) : comm_(comm) {
  MPI_Comm_rank(comm, &rank_);
  MPI_Comm_size(comm, &ranks_);
}

void DatasetWriter::sendRows(const char* rows, std::int64_t count, std::size_t rowBytes) const {
  for (std::int64_t done = 0; done < count; done += blockRows) {
    const auto now = static_cast<std::size_t>(std::min(blockRows, count - done));
    MPI_Send(rows + static_cast<std::size_t>(done) * rowBytes, static_cast<int>(now * rowBytes),
             MPI_BYTE, 0, tag, comm_);
  }
}

bool DatasetWriter::writeBytes(hid_t group, const char* name, Types types, const Shape& row,
                               const char* rows, std::int64_t count) {
  int good = good_;
  MPI_Bcast(&good, 1, MPI_INT, 0, comm_);
  good_ = good != 0;
  if (!good_) return false;
  std::vector<std::int64_t> counts(rank_ == 0 ? static_cast<std::size_t>(ranks_) : 0);
  MPI_Gather(&count, 1, MPI_INT64_T, counts.data(), 1, MPI_INT64_T, 0, comm_);
  std::size_t rowBytes = types.bytes;
  for (const hsize_t n : row) rowBytes *= static_cast<std::size_t>(n);
  if (rank_ != 0) return sendRows(rows, count, rowBytes), good_;

  std::int64_t total = 0;
  for (const std::int64_t c : counts) total += c;
  std::vector<hsize_t> shape{static_cast<hsize_t>(total)};
  shape.insert(shape.end(), row.begin(), row.end());
  Filling set(group, name, types.stored, types.memory, shape);
  good_ = set.valid();
  std::vector<char> block(static_cast<std::size_t>(std::min(total, blockRows)) * rowBytes), message;
  std::int64_t held = 0;
  auto take = [&](const char* from, std::int64_t number) {
    while (number > 0) {
      const std::int64_t now = std::min(number, blockRows - held);
      const auto bytes = static_cast<std::size_t>(now) * rowBytes;
      std::memcpy(block.data() + static_cast<std::size_t>(held) * rowBytes, from, bytes);
      from += bytes, held += now, number -= now;
      if (held == blockRows) good_ = good_ && set.append(block.data(), held), held = 0;
    }
  };
  take(rows, count);
  for (int r = 1; r < ranks_; ++r)
    for (std::int64_t left = counts[static_cast<std::size_t>(r)]; left > 0; left -= blockRows) {
      // After a failure, too, the others' messages are received: they would wait for ever.
      const std::int64_t now = std::min(left, blockRows);
      message.resize(static_cast<std::size_t>(now) * rowBytes);
      MPI_Recv(message.data(), static_cast<int>(message.size()), MPI_BYTE, r, tag, comm_,
               MPI_STATUS_IGNORE);
      take(message.data(), now);
    }
  if (held > 0) good_ = good_ && set.append(block.data(), held);
  return good_;
}

template <class T>
bool DatasetWriter::write(hid_t group, const char* name, const Shape& shape,
                          const std::vector<T>& rows) {
  Types types{};
  if constexpr (std::is_same_v<T, double>)
    types = {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, sizeof(T)};
  else if constexpr (std::is_same_v<T, float>)
    types = {H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, sizeof(T)};
  else if constexpr (std::is_same_v<T, std::int64_t>)
    types = {H5T_STD_I64LE, H5T_NATIVE_INT64, sizeof(T)};
  else if constexpr (std::is_same_v<T, std::int32_t>)
    types = {H5T_STD_I32LE, H5T_NATIVE_INT32, sizeof(T)};
  else
    types = {H5T_STD_I8LE, H5T_NATIVE_INT8, sizeof(T)};
  std::int64_t columns = 1;
  for (const hsize_t n : shape) columns *= static_cast<std::int64_t>(n);
  return writeBytes(group, name, types, shape, reinterpret_cast<const char*>(rows.data()),
                    static_cast<std::int64_t>(rows.size()) / columns);
}

template bool DatasetWriter::write(hid_t, const char*, const Shape&, const std::vector<double>&);
template bool DatasetWriter::write(hid_t, const char*, const Shape&, const std::vector<float>&);
template bool DatasetWriter::write(hid_t, const char*, const Shape&,
                                   const std::vector<std::int64_t>&);
template bool DatasetWriter::write(hid_t, const char*, const Shape&,
                                   const std::vector<std::int32_t>&);
template bool DatasetWriter::write(hid_t, const char*, const Shape&,
                                   const std::vector<std::int8_t>&);

}  // namespace nanoweft
