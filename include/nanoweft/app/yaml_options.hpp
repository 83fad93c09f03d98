/// Options in YAML.
#pragma once

#include <string>
#include <vector>

namespace nanoweft {

struct YamlOption {
  int line;
  std::string name;  ///< without -
  std::string value;
};

/// `ts_dt: 20` is the option -ts_dt 20; names of nested maps are joined by _, lists by commas; keys
/// that begin with $$ are no options, << merges a map. Throws InputError (`where`: what the message
/// begins with).
std::vector<YamlOption> parseYaml(const std::string& text, const std::string& where);

}  // namespace nanoweft
