#include "nanoweft/app/accounts_record.hpp"

#include <algorithm>
#include <array>

namespace nanoweft {

namespace {

/// Those that many runs do not have come last.
constexpr std::array names{"account_damped", "account_external", "account_broken",
                           "account_friction", "account_heat"};
constexpr std::size_t always = 3, heat = 4;
constexpr const char* groupsName = "account_groups";

}  // namespace

void saveAccounts(RunRecord& record, const EnergyAccounts& accounts, bool heated, MPI_Comm comm) {
  ExactSum sums[] = {accounts.damped, accounts.external, accounts.broken, accounts.friction,
                     accounts.heat};
  ExactSum::reduce(sums, names.size(), comm);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const std::vector<std::int64_t> account(sums[k].data(), sums[k].data() + 3);
    if (k < always || (k == heat && heated) || account != std::vector<std::int64_t>(3, 0))
      record.integers[names[k]] = account;
  }
  if (accounts.groups.empty()) return;
  std::vector<ExactSum> groups = accounts.groups;
  ExactSum::reduce(groups.data(), static_cast<int>(groups.size()), comm);
  auto& integers = record.integers[groupsName];
  for (const ExactSum& sum : groups) integers.insert(integers.end(), sum.data(), sum.data() + 3);
}

void restoreAccounts(EnergyAccounts& accounts, const RunRecord& record, bool heated, int rank) {
  ExactSum* sums[] = {&accounts.damped, &accounts.external, &accounts.broken, &accounts.friction,
                      &accounts.heat};
  for (std::size_t k = 0; k < names.size(); ++k) {
    const bool needed = k < always || (k == heat && heated);
    if (!needed && !record.integers.contains(names[k])) continue;
    const auto& account = record.needIntegers(names[k], 3);
    if (rank == 0) std::ranges::copy(account, sums[k]->data());
  }
  if (accounts.groups.empty()) return;
  const auto& groups = record.needIntegers(groupsName, 3 * accounts.groups.size());
  for (std::size_t k = 0; rank == 0 && k < accounts.groups.size(); ++k)
    std::copy_n(groups.begin() + static_cast<std::ptrdiff_t>(3 * k), 3, accounts.groups[k].data());
}

}  // namespace nanoweft
