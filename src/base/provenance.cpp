#include "nanoweft/base/provenance.hpp"

#include <sstream>

namespace nanoweft {

namespace {

constexpr const char* inputMark = "# input ";

}  // namespace

std::string Provenance::tableHead() const {
  std::string head = "# " + program + " " + version + "\n";
  std::istringstream lines(options);
  for (std::string line; std::getline(lines, line);) head += "# " + line + "\n";
  if (!input.empty()) head += inputMark + input + "\n";
  return head;
}

std::optional<Provenance> Provenance::fromTable(std::istream& in) {
  if (in.peek() != '#') return std::nullopt;
  Provenance result;
  std::string line;
  std::getline(in, line);
  std::istringstream first(line.substr(1));
  first >> result.program >> result.version;
  while (in.peek() == '#' && std::getline(in, line)) {
    if (line.starts_with(inputMark))
      result.input = line.substr(std::string(inputMark).size());
    else if (line.starts_with("# -"))
      result.options += line.substr(2) + "\n";
  }
  return result;
}

}  // namespace nanoweft
