/// Can a file be used as a state? All but the values of the rows.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "nanoweft/base/error.hpp"
#include "nanoweft/state/kind_names.hpp"
#include "nanoweft/state/link_file.hpp"
#include "nanoweft/state/open_state.hpp"
#include "nanoweft/state/state_file.hpp"
#include "nanoweft/state/state_format.hpp"
#include "nanoweft/state/state_read.hpp"
#include "nanoweft/state/state_signature.hpp"

namespace nanoweft {

namespace {

constexpr const char* remedy =
    "; take an intact copy, or where a person edited it on purpose start from it with -scene file "
    "and -scene_file_edited";

bool allFinite(const std::vector<double>& values) {
  return std::ranges::all_of(values, [](double x) { return std::isfinite(x); });
}

/// Slides of the images: along x across y, along x across z, along y across z.
void checkTilt(const OpenState& state, const std::vector<std::int64_t>& periodic) {
  const auto tilt = h5::readReals(state.segments(), "tilt");
  if (!tilt || tilt->size() != 3 || !allFinite(*tilt) || std::ranges::count(*tilt, 0.0) < 2)
    state.refuse("the attribute tilt must be three finite numbers, of which at most one is not 0");
  for (int pair = 0; pair < 3; ++pair) {
    if ((*tilt)[static_cast<std::size_t>(pair)] == 0) continue;
    const Tilt own = Tilt::ofPair(pair, 1.0);
    if (!periodic[static_cast<std::size_t>(own.along)] ||
        !periodic[static_cast<std::size_t>(own.across)])
      state.refuse(
          format("its box is tilted along %c across %c (attribute tilt), where it must be "
                 "periodic",
                 "xyz"[own.along], "xyz"[own.across]));
  }
}

void checkAttributes(const OpenState& state, bool complete) {
  const hid_t group = state.segments();
  const auto name = h5::readText(group, "format");
  if (!name || *name != stateFormatName)
    state.refuse(std::string("the attribute format of /state is not '") + stateFormatName + "'");
  const auto version = h5::readIntegers(group, "version");
  if (!version || version->size() != 1 || (*version)[0] != stateFormatVersion)
    state.refuse("its version is not 1");
  const auto units = h5::readText(group, "units");
  if (!units || (*units != "nano" && *units != "si"))
    state.refuse("the attribute units must be 'nano' or 'si'");
  for (const char* corner : {"lower", "upper"}) {
    const auto values = h5::readReals(group, corner);
    if (!values || values->size() != 3 || !allFinite(*values))
      state.refuse(std::string("the attribute ") + corner + " must be three finite numbers");
  }
  const auto lower = *h5::readReals(group, "lower"), upper = *h5::readReals(group, "upper");
  for (std::size_t d = 0; d < 3; ++d)
    if (!(lower[d] < upper[d])) state.refuse("the box has no extent (attributes lower and upper)");
  const auto periodic = h5::readIntegers(group, "periodic");
  if (!periodic || periodic->size() != 3 ||
      !std::ranges::all_of(*periodic, [](auto p) { return p == 0 || p == 1; }))
    state.refuse("the attribute periodic must be three integers, each 0 or 1");
  if (H5Aexists(group, "tilt") > 0) checkTilt(state, *periodic);
  auto wanted = [&](const char* attribute) { return complete || H5Aexists(group, attribute) != 0; };
  if (const auto step = h5::readIntegers(group, "step");
      wanted("step") && (!step || step->size() != 1 || (*step)[0] < 0))
    state.refuse("the attribute step must be a whole number, not negative");
  if (const auto time = h5::readReals(group, "time");
      wanted("time") && (!time || time->size() != 1 || !allFinite(*time)))
    state.refuse("the attribute time must be a finite number");
}

/// Looks at one dataset of /state; returns its rows, or -1 when it is not there.
std::int64_t checkDataset(const OpenState& state, const h5::Expected& expected, bool complete) {
  if (h5::find(state.segments(), expected.name) == h5::Found::nothing) return -1;
  const h5::Shape shape = h5::inspect(state.segments(), expected);
  const std::string what = std::string("/state/") + expected.name + " ";
  if (!shape.problem.empty()) state.refuse(what + shape.problem);
  if (complete && !shape.written) state.refuse(what + "was never written, or only in part");
  return shape.rows;
}

void checkDatasets(const OpenState& state, bool complete) {
  auto refuseShape = [&](const h5::Expected& e) {
    state.refuse(format("/state/%s must have the shape [N%s] with the same N > 0 as position",
                        e.name, e.columns == 1 ? "" : format(", %d", e.columns).c_str()));
  };
  std::int64_t total = 0;
  for (const h5::Expected& e : {rows::position, rows::orientation, rows::fibre, rows::index}) {
    const std::int64_t rows = checkDataset(state, e, true);
    if (rows < 0) state.refuse(std::string("/state/") + e.name + " is missing");
    if (total == 0) total = rows;
    if (total == 0 || rows != total) refuseShape(e);
  }
  std::vector<h5::Expected> others{rows::image, rows::bondBroken, rows::kind};
  for (const Field& f : fields)
    if (readByName(f)) others.push_back(expectedOf(state, f));
  for (const h5::Expected& e : others)
    if (const std::int64_t rows = checkDataset(state, e, complete); rows >= 0 && rows != total)
      refuseShape(e);
  if (total > 2147483647) state.refuse("more than 2^31 - 1 segments");
  if (checkDataset(state, rows::fibreClosed, complete) > total)
    state.refuse("/state/fibre_closed has more entries than there are segments");
}

}  // namespace

CheckedState checkState(const std::string& file, Trust trust) {
  OpenState state(file);
  const SignatureCheck signature = checkSignature(state.descriptor());
  if (signature.result == SignatureCheck::unreadable) state.refuse(std::strerror(signature.reason));
  const bool edited = trust == Trust::edited;
  if (signature.result == SignatureCheck::damaged && !edited)
    state.refuse(std::string("it is damaged or was changed after nanoweft wrote it (its SHA-256 "
                             "differs)") +
                 remedy);
  state.openGroups();
  CheckedState result;
  result.digest = signature.digest;
  if (state.hasRecord()) {
    for (const auto& [key, text] : {std::pair{programText, &result.run.program},
                                    {versionText, &result.run.version},
                                    {optionsText, &result.run.options},
                                    {inputText, &result.run.input}})
      *text = h5::readText(state.record(), key).value_or("");
    result.byProgram = H5Aexists(state.record(), programText) != 0;
  }
  if (result.byProgram && signature.result == SignatureCheck::unsigned_ && !edited)
    state.refuse(std::string("nanoweft wrote it, but its first line with the SHA-256 is gone") +
                 remedy);
  const bool complete = state.hasRecord() && !edited;
  checkAttributes(state, complete);
  checkDatasets(state, complete);
  readKindNames(state, kindsOfFibres);
  if (state.hasLinks()) {
    readLinkRows(state);
    readKindNames(state, kindsOfLinks);
  }
  return result;
}

std::string stateFileProblem(const std::string& file, Trust trust) {
  try {
    checkState(file, trust);
    return "";
  } catch (const InputError& problem) {
    return problem.what();
  }
}

}  // namespace nanoweft
