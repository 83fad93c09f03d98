#include "nanoweft/app/accounts_record.hpp"

#include <algorithm>
#include <array>

namespace nanoweft {

namespace {

constexpr std::array names{"account_damped", "account_external", "account_broken"};

}  // namespace

void saveAccounts(RunRecord& record, const EnergyAccounts& accounts, MPI_Comm comm) {
  ExactSum sums[] = {accounts.damped, accounts.external, accounts.broken};
  ExactSum::reduce(sums, names.size(), comm);
  for (std::size_t k = 0; k < names.size(); ++k)
    record.integers[names[k]] = std::vector<std::int64_t>(sums[k].data(), sums[k].data() + 3);
}

void restoreAccounts(EnergyAccounts& accounts, const RunRecord& record, int rank) {
  ExactSum* sums[] = {&accounts.damped, &accounts.external, &accounts.broken};
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto& account = record.needIntegers(names[k], 3);
    if (rank == 0) std::ranges::copy(account, sums[k]->data());
  }
}

}  // namespace nanoweft
