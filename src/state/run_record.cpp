#include "nanoweft/base/error.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

namespace {

template <class T>
const std::vector<T>& need(const std::map<std::string, std::vector<T>>& all,
                           const std::string& source, const std::string& name, std::size_t count) {
  const auto it = all.find(name);
  if (it == all.end())
    throw InputError(
        format("state file %s: its attribute %s of /run is missing, without which the run cannot "
               "go on",
               source.c_str(), name.c_str()));
  if (it->second.size() != count)
    throw InputError(format("state file %s: its attribute %s of /run must be %zu numbers",
                            source.c_str(), name.c_str(), count));
  return it->second;
}

}  // namespace

const std::vector<double>& RunRecord::needReals(const std::string& name, std::size_t count) const {
  return need(reals, source, name, count);
}

const std::vector<std::int64_t>& RunRecord::needIntegers(const std::string& name,
                                                         std::size_t count) const {
  return need(integers, source, name, count);
}

}  // namespace nanoweft
