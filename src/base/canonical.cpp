#include "nanoweft/base/canonical.hpp"

#include <charconv>

namespace nanoweft {

namespace {

template <class Values>
std::string joined(const Values& values) {
  std::string text;
  for (const auto& value : values) text += (text.empty() ? "" : ",") + canonical(value);
  return text;
}

}  // namespace

std::string canonical(double value) {
  if (value == 0) return "0";  // -0 as well
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  std::string text(buffer, end);
  // 1e+06 and 1e-06 as people write them.
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return text;
  std::size_t digits = e + 1;
  if (text[digits] == '+')
    text.erase(digits, 1);
  else if (text[digits] == '-')
    ++digits;
  while (text[digits] == '0' && digits + 1 < text.size()) text.erase(digits, 1);
  return text;
}

std::string canonical(long value) {
  return std::to_string(value);
}

std::string canonical(bool value) {
  return value ? "true" : "false";
}

std::string canonical(const std::string& value) {
  return value;
}

std::string canonical(const std::vector<double>& values) {
  return joined(values);
}

std::string canonical(const std::vector<std::string>& values) {
  return joined(values);
}

std::string canonical(const std::array<bool, 3>& values) {
  return joined(std::array{values[0] ? 1L : 0L, values[1] ? 1L : 0L, values[2] ? 1L : 0L});
}

}  // namespace nanoweft
