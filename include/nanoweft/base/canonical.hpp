/// One way of writing for each value of an option, so that texts are equal where values are.
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
