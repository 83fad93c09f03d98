#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

std::map<std::string, std::string> provenanceTexts(const Provenance& run,
                                                   const std::string& purpose) {
  std::map<std::string, std::string> texts{{programText, run.program},
                                           {versionText, run.version},
                                           {optionsText, run.options},
                                           {purposeText, purpose}};
  if (!run.input.empty()) texts[inputText] = run.input;
  return texts;
}

Provenance provenanceOf(const RunRecord& record) {
  auto text = [&](const char* key) {
    const auto found = record.texts.find(key);
    return found == record.texts.end() ? std::string() : found->second;
  };
  return {text(programText), text(versionText), text(optionsText), text(inputText)};
}

}  // namespace nanoweft
