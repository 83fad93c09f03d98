/// The canonical text of an option's value, by which options of two runs are compared.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace nanoweft {

/// The shortest text that reads back as the same number: `0.4`, `2e-7`, `1e5`.
std::string canonical(double value);
std::string canonical(long value);
/// `true` or `false`.
std::string canonical(bool value);
std::string canonical(const std::string& value);
/// Elements separated by commas.
std::string canonical(const std::vector<double>& values);
std::string canonical(const std::vector<std::string>& values);
/// `1,0,1`.
std::string canonical(const std::array<bool, 3>& values);

}  // namespace nanoweft
