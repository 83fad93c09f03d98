/// A state file that is open for reading, by one process.
#pragma once

#include <string>

#include "nanoweft/base/hdf5.hpp"
#include "nanoweft/base/hdf5_driver.hpp"
#include "nanoweft/base/hdf5_numbers.hpp"
#include "nanoweft/base/output_file.hpp"
#include "nanoweft/state/fields.hpp"

namespace nanoweft {

class OpenState {
 public:
  /// Throws InputError, with the reason, for what is no readable HDF5 file with a group /state.
  explicit OpenState(const std::string& file);
  ~OpenState();
  OpenState(const OpenState&) = delete;
  OpenState& operator=(const OpenState&) = delete;

  int descriptor() const { return open_.descriptor; }
  /// Opens the file for HDF5: a file may be looked at before.
  void openGroups();
  hid_t file() const { return file_; }
  hid_t segments() const { return segments_; }  ///< /state
  hid_t record() const { return record_; }      ///< /run
  bool hasRecord() const { return record_.valid(); }
  /// The group /link, which not every file has.
  bool hasLinks() const { return links_.valid(); }
  hid_t links() const { return links_; }
  FileIdentity identity() const { return FileIdentity::of(open_.descriptor); }

  /// "state file F cannot be used: reason" as InputError.
  [[noreturn]] void refuse(const std::string& reason) const;

 private:
  std::string name_;
  h5::OpenFile open_;
  h5::Handle file_, segments_, record_, links_;
};

// The datasets of /state that are not fields by their names.
namespace rows {
inline constexpr h5::Expected position{"position", 3, false}, orientation{"orientation", 4, false},
    fibre{"fibre", 1, true}, index{"index", 1, true}, image{"image", 3, true},
    bondBroken{"bond_broken", 1, true}, fibreClosed{"fibre_closed", 1, true}, kind{"kind", 1, true};
}  // namespace rows

/// Of those that are, what a reader looks at.
inline bool readByName(const Field& f) {
  return f.stored == Stored::always || f.stored == Stored::extra;
}
/// What the file may have of a field. Files of earlier programs keep half as many contacts of a
/// segment.
inline h5::Expected expectedOf(const OpenState& file, const Field& f) {
  const h5::Expected now{f.name, f.components, f.whole()},
      former{f.name, f.components / 2, f.whole()};
  const bool half = f.extra == &ExtraFields::friction &&
                    h5::find(file.segments(), f.name) == h5::Found::dataset &&
                    h5::inspect(file.segments(), former).problem.empty();
  return half ? former : now;
}

}  // namespace nanoweft
