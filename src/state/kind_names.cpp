#include "nanoweft/state/kind_names.hpp"

#include <algorithm>

#include "nanoweft/base/hdf5.hpp"

namespace nanoweft {

namespace {

constexpr const char* attribute = "kinds";

}  // namespace

std::vector<std::string> readKindNames(const OpenState& file, const KindPlace& place) {
  if (H5Lexists(file.file(), place.dataset, H5P_DEFAULT) <= 0) return {};
  const h5::Handle set(H5Dopen2(file.file(), place.dataset, H5P_DEFAULT), H5Dclose);
  if (!set.valid() || H5Aexists(set, attribute) <= 0) return {};
  const auto names = h5::readTexts(set, attribute);
  if (!names)
    file.refuse(std::string("the attribute kinds of ") + place.dataset +
                " must be names of kinds: an array of texts, or one text with commas between them");
  return *names;
}

void writeKindNames(DatasetWriter& writer, hid_t group, const std::vector<std::string>& names) {
  const h5::Handle set(H5Dopen2(group, "kind", H5P_DEFAULT), H5Dclose);
  writer.note(set.valid() && h5::writeAttribute(set, attribute, listOf(names)));
}

std::string listOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ",") + name;
  return list;
}

KindNumbers::KindNumbers(const KindPlace& place, const std::vector<std::string>& theirs,
                         const std::vector<std::string>& known) {
  const std::string dataset = place.dataset, option = place.option;
  for (std::size_t k = 0; theirs.empty() && k < known.size(); ++k)
    numbers_.push_back(static_cast<int>(k));
  for (const std::string& name : theirs) {
    if (std::ranges::count(theirs, name) > 1)
      problem_ = "the attribute kinds of " + dataset + " names '" + name + "' twice";
    const auto at = std::ranges::find(known, name);
    numbers_.push_back(at == known.end() ? -1 : static_cast<int>(at - known.begin()));
    if (at == known.end() && problem_.empty())
      problem_ = "its " + dataset + " has the kind '" + name + "', which " +
                 (known[0].empty() ? option + " must name"
                                   : "is not among " + option + " " + listOf(known));
  }
}

}  // namespace nanoweft
