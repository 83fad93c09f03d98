#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

std::vector<std::string> partsOfState(const ExtraFields& extras) {
  std::vector<std::string> parts{"step",        "time",  "position", "image",
                                 "orientation", "fibre", "index",    "bond_broken"};
  for (const Field& f : fields)
    if (f.stored == Stored::always || (f.stored == Stored::extra && f.in(extras)))
      parts.push_back(f.name);
  return parts;
}

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
